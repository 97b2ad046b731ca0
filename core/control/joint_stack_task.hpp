// The joint tasks of a stack: an impedance about a fixed reference, and about one that moves along a spline.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "control/joint_task.hpp"
#include "control/mailbox.hpp"
#include "control/quintic.hpp"
#include "control/task.hpp"
#include "model/robot_model.hpp"

namespace robotskin::control {

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

  std::vector<double> goal_, reference_, reference_velocity_;  // (n)
  std::vector<double> lower_, upper_;                          // (n)

 private:
  Mailbox goal_box_, gain_box_;
  std::vector<double> stiffness_, damping_;     // (n) in use
  std::vector<double> gain_, asked_, scratch_;  // (2 n) stiffness, then damping
};

// The reference moves to each goal along a quintic, no joint faster than `speed`.
class SplineJointTask final : public JointTask {
 public:
  // speed in rad/s, > 0.
  SplineJointTask(const RobotModel& robot, JointGains gains, double speed);

  void start(const TaskInput& input) noexcept override;
  bool arrived() const noexcept { return time_s_ >= duration_s_; }

 protected:
  void follow(const TaskInput& input, bool fresh) noexcept override;

 private:
  double speed_;
  double time_s_ = 0, duration_s_ = 0;
  std::vector<Quintic> splines_;  // (n)
};

}  // namespace robotskin::control
