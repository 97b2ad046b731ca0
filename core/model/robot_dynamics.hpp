// SPDX-License-Identifier: Apache-2.0
// A robot at one posture: where its links are and how it answers to forces. The workspace of one thread.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>

#include "model/robot_model.hpp"

namespace robotskin {

// Holds what follows from the last accepted update(q, v). Matrices are row-major doubles; everything is given in the
// base frame: m, rad, kg, Nm. No function but the constructor allocates or throws.
// The equation of motion is M(q) a + C(q, v) v + g(q) = tau.
class RobotDynamics {
 public:
  // Keeps what it needs of the model alive; every result is that of q = 0, v = 0 until the first update.
  explicit RobotDynamics(const RobotModel& model);
  ~RobotDynamics();
  RobotDynamics(RobotDynamics&&) noexcept;
  RobotDynamics& operator=(RobotDynamics&&) noexcept;

  std::size_t joint_count() const noexcept;
  std::size_t link_count() const noexcept;

  // Computes all results below for positions q (n) and velocities v (n). False, with every result left as it was, if
  // a count is wrong or a value is not finite.
  [[nodiscard]] bool update(std::span<const double> q, std::span<const double> v) noexcept;

  std::span<const double> base_from_joint() const noexcept;  // (n, 4, 4)
  // (n, 6) Motion of a unit velocity of each joint: velocity of the body point that passes the base origin (3),
  // then angular velocity (3). Column i of the spatial Jacobian.
  std::span<const double> joint_motions() const noexcept;
  std::span<const double> mass_matrix() const noexcept;        // (n, n) M, symmetric
  std::span<const double> gravity_torque() const noexcept;     // (n) g: the torque that holds the robot still
  std::span<const double> nonlinear_effects() const noexcept;  // (n) C v + g

  double mass() const noexcept;                           // kg, of all links
  std::array<double, 3> centre_of_mass() const noexcept;  // metres, of all links
  // out (3, n): velocity of the centre of mass per joint velocity. False if the count is wrong.
  [[nodiscard]] bool centre_of_mass_jacobian(std::span<double> out) const noexcept;

  // acceleration (n) = M^-1 (torque - C v - g). False if a count is wrong; the arrays may be the same.
  [[nodiscard]] bool forward_dynamics(std::span<const double> torque, std::span<double> acceleration) const noexcept;
  // solution (n) = M^-1 right_side. False if a count is wrong; the arrays may be the same.
  [[nodiscard]] bool solve_mass(std::span<const double> right_side, std::span<double> solution) const noexcept;

  // out (4, 4). False if there is no such link or the count is wrong.
  [[nodiscard]] bool base_from_link(std::size_t link, std::span<double> out) const noexcept;
  // out (6, n): velocity of the link's origin (3 rows), then its angular velocity (3 rows), per joint velocity, along
  // the axes of the base. False if there is no such link or the count is wrong.
  [[nodiscard]] bool link_jacobian(std::size_t link, std::span<double> out) const noexcept;

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace robotskin
