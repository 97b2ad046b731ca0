// SPDX-License-Identifier: Apache-2.0
// Compliance of the whole robot: what a limb cannot give at its contacts is handed to the limb that carries it.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "control/contact_impedance_task.hpp"
#include "control/contact_points.hpp"
#include "control/fade.hpp"
#include "control/limb_programme.hpp"
#include "control/quadratic_fusion.hpp"
#include "control/task.hpp"
#include "control/touch_wrench.hpp"

namespace robotskin::control {

struct PropagationGains {
  // Of the motion that each contact is to have [Cheng19 eq. 26]; critically damped.
  ContactImpedanceGains impedance{.inertia = 2.5, .damping = 14.2, .stiffness = 20};
  ContactGains contacts;
  double largest_speed_m_s = 0.25;    // of that motion
  double largest_joint_speed = 1.57;  // rad/s or m/s, where 95 % of a joint's velocity limit is not less
  double largest_lead_m = 0.05;       // by which it may run ahead of the contact
  double tracking_per_s = 10;         // how fast the contact comes back to it
  double effort = 1e-4;               // epsilon of [Cheng19 eq. 27]
  // What a limb leaves undone of a contact's acceleration and does not hand on. By this over tracking_per_s^2 a contact
  // is behind its motion before the parent moves, which rests where the limb suffices.
  double kept_m_s2 = 0.3;
  double return_per_s = 1;  // how fast joints go back to their reference
  double begin_s = 0.25;    // in which the contacts that there are at the start come to count
  std::size_t sweeps = 4;   // over all limbs in a tick
  std::size_t steps = 400;  // of the solver, in a tick
};

// A contact is drawn to where its point of the body lies in the reference posture, which is that of the start. Its
// desired motion is integrated beside the robot. Limbs are solved from the outermost inwards: each gives its contacts
// what it can within its limits, and hands the residual of their accelerations to its parent, less what it may keep.
// The parent's programme has the residuals of all limbs that it carries. What is left after the last one goes back to
// the first: an arm alone does not know that what is level of its task could be left to the base. After some sweeps all
// limbs together do nearly as well as one programme over all joints would. Joints of no limb keep to the reference.
//
// The torque gives all joints the accelerations found, gravity excepted. Claims 3 rows for each contact.
class PropagatedComplianceTask final : public Task {
 public:
  // `touch`: a touch of weight 1, so that its magnitudes are newton; its weight of nearness makes that a push. Throws
  // ControlError for limbs and gains that do not fit.
  PropagatedComplianceTask(const RobotModel& robot, const skin::SkinModel& skin, std::shared_ptr<TouchWrench> touch,
                           const std::vector<Limb>& limbs, PropagationGains gains);
  void start(const TaskInput& input) noexcept override;
  [[nodiscard]] bool update(const TaskInput& input) noexcept override;

  // Of the last update.
  std::span<const Contact> contacts() const noexcept { return points_.contacts(); }
  // m/s^2 of its contacts' accelerations that the limb has left undone: the root of the sum of the squares.
  double residual(std::size_t limb) const noexcept { return residuals_[limb]; }
  std::size_t limb_count() const noexcept { return programmes_.size(); }
  const std::string& limb_name(std::size_t limb) const noexcept { return programmes_[limb].limb().name; }
  // (n) rad/s^2 that the joints are to have.
  std::span<const double> acceleration() const noexcept { return acceleration_; }

 private:
  struct Motion {  // of a contact: where [Cheng19 eq. 26] has it, from its place in the reference posture
    Vector3 moved{}, velocity{};
    Vector3 point{};  // of the last tick, in the joint's frame
  };
  void follow_bodies(const TaskInput& input) noexcept;
  void set_free_accelerations(const TaskInput& input) noexcept;
  void add_contact(const TaskInput& input, std::size_t index) noexcept;
  Vector3 asked(const Contact& contact, Motion& motion, const Vector3& reference, const Vector3& point,
                const Vector3& velocity, const double* base_from_joint, double period_s) const noexcept;
  bool solve(const TaskInput& input, std::size_t limb, StepBudget& budget) noexcept;

  std::shared_ptr<TouchWrench> touch_;
  PropagationGains gains_;
  QuadraticLimits limits_;
  ContactPoints points_;
  std::vector<LimbProgramme> programmes_;
  std::vector<std::size_t> leaf_;  // (bodies) the outermost limb that carries the body, or no_parent
  std::vector<Motion> motions_;    // (contacts)
  RobotDynamics reference_dynamics_;
  std::vector<double> reference_, largest_;  // (n)
  std::vector<double> velocity6_, drift6_;   // (n, 6) of each joint's body: velocity, and acceleration without a''
  std::vector<double> low_, high_, free_, acceleration_;  // (n) rad/s^2: bounds, without contacts, with them
  // Of the contacts of this tick.
  std::vector<std::size_t> active_;
  std::vector<double> jacobian_, residual_;  // (3 contacts, n), (3 contacts)
  // Of a limb.
  std::vector<double> limb_jacobian_, limb_residual_, limb_mass_, limb_values_;
  std::vector<double> residuals_;  // (limbs)
  Fade begins_;
  double begun_ = 0;  // 0 to 1
};

}  // namespace robotskin::control
