// SPDX-License-Identifier: Apache-2.0
// What is constant about a robot: joints, links and limits, read once from a URDF.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace robotskin {

// A robot description that cannot be used; the message names the robot, the joint or link, and the valid choices.
class ModelError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

enum class JointKind : std::uint8_t { revolute, prismatic };

// A tree of n joints with one degree of freedom each, on a base that is fixed, and the links they carry. A link that
// hangs on fixed joints belongs to the moving joint above them, or to joint `base`.
// Matrices are row-major doubles; lengths in m, angles in rad. Immutable, so threads may share it.
class RobotModel {
 public:
  static constexpr int base = -1;
  // A position limit of this size or more, rad or m, stands for none: URDF text cannot say infinity.
  static constexpr double unbounded = 1e9;

  // Inertia of the motors' rotors as the joints feel it through their gears, kg m^2 or kg by name of the joint. A URDF
  // has no place for it. It is part of the mass matrix; joints that are not named have none.
  using RotorInertia = std::map<std::string, double>;

  // Throws ModelError for text that is not a URDF, for a joint that is not revolute, prismatic or fixed, and for a
  // rotor's inertia that is negative, not finite or of no joint. A continuous joint has to be written as a revolute one
  // with unbounded limits, so that every joint has one position.
  explicit RobotModel(const std::string& urdf, const RotorInertia& rotor_inertia = {});

  const std::string& name() const noexcept { return name_; }
  std::size_t joint_count() const noexcept { return joint_names_.size(); }
  std::size_t link_count() const noexcept { return link_names_.size(); }

  // Joints: parents come before their children.
  std::span<const std::string> joint_names() const noexcept { return joint_names_; }
  std::span<const int> joint_parents() const noexcept { return joint_parents_; }    // (n) joint index or base
  std::span<const JointKind> joint_kinds() const noexcept { return joint_kinds_; }  // (n)
  std::span<const double> joint_axes() const noexcept { return joint_axes_; }       // (n, 3) unit, in the joint frame
  std::span<const double> parent_from_joint() const noexcept { return parent_from_joint_; }  // (n, 4, 4) at zero
  std::span<const double> lower() const noexcept { return lower_; }                    // (n) rad or m, -inf: unbounded
  std::span<const double> upper() const noexcept { return upper_; }                    // (n) rad or m, +inf: unbounded
  std::span<const double> velocity_limit() const noexcept { return velocity_limit_; }  // (n) rad/s or m/s
  std::span<const double> effort_limit() const noexcept { return effort_limit_; }      // (n) Nm or N
  std::span<const double> joint_damping() const noexcept { return joint_damping_; }    // (n) Nm s/rad or N s/m, >= 0
  std::span<const double> rotor_inertia() const noexcept { return rotor_inertia_; }    // (n) kg m^2 or kg, >= 0
  // Whether a motor drives the joint. Not actuated are the six joints of a base that floats alone: the first six, three
  // that slide and three that turn, each carried by the one before, all with an effort limit of 0. Any other joint with
  // an effort limit of 0 has a motor of which nothing is known.
  bool actuated(std::size_t joint) const noexcept { return joint >= floating_joints_; }

  // Links, the base link first.
  std::span<const std::string> link_names() const noexcept { return link_names_; }
  std::span<const int> link_joints() const noexcept { return link_joints_; }             // (l) joint index or base
  std::span<const double> joint_from_link() const noexcept { return joint_from_link_; }  // (l, 4, 4) constant

  // Throw ModelError, with the names there are, for a name that is none of them.
  std::size_t joint_index(std::string_view joint) const;
  std::size_t link_index(std::string_view link) const;

 private:
  friend class RobotDynamics;

  std::string name_;
  std::vector<std::string> joint_names_, link_names_;
  std::vector<int> joint_parents_, link_joints_;
  std::vector<JointKind> joint_kinds_;
  std::vector<double> joint_axes_, parent_from_joint_, joint_from_link_;
  std::vector<double> lower_, upper_, velocity_limit_, effort_limit_, joint_damping_, rotor_inertia_;
  std::size_t floating_joints_ = 0;
  std::shared_ptr<const void> pinocchio_model_;  // a pinocchio::Model, a type that costs a minute to know
};

}  // namespace robotskin
