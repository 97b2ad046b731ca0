// SPDX-License-Identifier: Apache-2.0
// Joint task: an impedance that draws every joint to its reference.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "control/task.hpp"
#include "control/vector_mailbox.hpp"
#include "model/robot_model.hpp"

namespace robotskin::control {

struct JointGains {
  std::vector<double> stiffness;  // (n) Nm/rad
  std::vector<double> damping;    // (n) Nm s/rad, beside the friction of the torque resolver
};

// Throws ControlError, naming the task, unless both have `joint_count` finite values that are not negative.
void check_joint_gains(const JointGains& gains, std::size_t joint_count, const std::string& task);

// torque = K (reference - q) + D (reference' - v); claims every joint that has stiffness or damping, so that as a
// posture it stands on the lowest level. The gains of a joint that does not take part are zero.
class JointTask : public Task {
 public:
  // Throws ControlError for gains that do not fit the robot. The reference is where the task starts.
  JointTask(const RobotModel& robot, JointGains gains, std::string name = "joint");

  // From any thread; (n) rad inside the limits, else ControlError. It takes effect at once.
  void request_reference(std::span<const double> reference);
  // From any thread; the gains in use move to these within `fade_s`. Throws ControlError.
  void request_gains(const JointGains& gains);

  void start(const TaskInput& input) noexcept override;
  [[nodiscard]] bool update(const TaskInput& input) noexcept override;
  std::span<const double> reference() const noexcept { return reference_; }  // (n) rad

  static constexpr double fade_s = 0.25;

 protected:
  // Moves reference_ and reference_velocity_ by a period; `fresh` tells that goal_ is a new one.
  virtual void follow(const TaskInput& input, bool fresh) noexcept;
  // Whether a joint has gains, so that the task moves it.
  bool takes_part(std::size_t joint) const noexcept { return asked_[joint] > 0 || asked_[joint_count() + joint] > 0; }

  std::vector<double> goal_, reference_, reference_velocity_;  // (n)
  std::vector<double> lower_, upper_;                          // (n)

 private:
  VectorMailbox goal_box_, gain_box_;
  std::vector<double> stiffness_, damping_;     // (n) in use
  std::vector<double> gain_, asked_, scratch_;  // (2 n) stiffness, then damping
};

}  // namespace robotskin::control
