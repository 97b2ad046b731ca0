// SPDX-License-Identifier: Apache-2.0
#include "control/joint_limit_task.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "control/control_error.hpp"

namespace robotskin::control {

JointLimitTask::JointLimitTask(const RobotModel& robot, JointLimitGains gains)
    : Task("joint limits", robot.joint_count(), robot.joint_count()),
      gains_(gains),
      lower_(robot.lower().begin(), robot.lower().end()),
      upper_(robot.upper().begin(), robot.upper().end()) {
  for (const double value : {gains.margin_rad, gains.stiffness, gains.damping})
    if (!(value > 0) || !std::isfinite(value))
      throw ControlError("joint limit task: gain " + std::to_string(value) + " must be finite and greater than 0");
}

bool JointLimitTask::update(const TaskInput& input) noexcept {
  const std::size_t joints = joint_count();
  row_count_ = 0;
  for (std::size_t i = 0; i < joints; ++i) {
    // Of a joint with little room the margins do not meet.
    const double margin = std::min(gains_.margin_rad, 0.25 * (upper_[i] - lower_[i]));
    const double below = lower_[i] + margin - input.position[i];
    const double above = input.position[i] - (upper_[i] - margin);
    const double depth = std::max(below, above);
    torque_[i] = 0;
    if (!(depth > 0)) continue;
    const double x = std::min(depth / margin, 1.0);
    const double active = x * x * (3 - 2 * x);
    const double away = below > above ? 1 : -1;
    torque_[i] = active * (away * gains_.stiffness * depth - gains_.damping * input.velocity[i]);
    double* row = &rows_[row_count_++ * joints];
    std::fill_n(row, joints, 0.0);
    row[i] = active;
  }
  return true;
}

}  // namespace robotskin::control
