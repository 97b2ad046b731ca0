// SPDX-License-Identifier: Apache-2.0
// Joint-limit avoidance: pushes every joint that comes near its position limit back, and lays claim to it.
#pragma once

#include <vector>

#include "control/task.hpp"
#include "model/robot_model.hpp"

namespace robotskin::control {

struct JointLimitGains {
  double margin_rad = 0.1;  // the task begins to act this far before a limit
  double stiffness = 100;   // Nm/rad at the limit
  double damping = 5;       // Nm s/rad at the limit
};

// With x, 0 at the margin and 1 at the limit and beyond, and a = x^2 (3 - 2 x):
// torque = a (stiffness * depth into the margin - damping v), and a row of a for the joint.
class JointLimitTask final : public Task {
 public:
  // Throws ControlError for gains that are not finite and positive.
  JointLimitTask(const RobotModel& robot, JointLimitGains gains);
  [[nodiscard]] bool update(const TaskInput& input) noexcept override;

 private:
  JointLimitGains gains_;
  std::vector<double> lower_, upper_;
};

}  // namespace robotskin::control
