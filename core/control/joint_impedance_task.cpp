// SPDX-License-Identifier: Apache-2.0
#include "control/joint_impedance_task.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "control/control_error.hpp"
#include "model/spatial.hpp"

namespace robotskin::control {

JointImpedanceTask::JointImpedanceTask(const RobotModel& robot, JointGains gains)
    : Task("joint impedance", robot.joint_count(), robot.joint_count()),
      lower_(robot.lower().begin(), robot.lower().end()),
      upper_(robot.upper().begin(), robot.upper().end()),
      box_(2 * robot.joint_count()),
      reference_(2 * robot.joint_count()),
      scratch_(2 * robot.joint_count()),
      push_(robot.joint_count()),
      acceleration_of_(robot.joint_count()) {
  check_joint_gains(gains, robot.joint_count(), name());
  gains_ = std::move(gains);
  row_count_ = joint_count();
  for (std::size_t i = 0; i < joint_count(); ++i) rows_[i * joint_count() + i] = 1;
}

void JointImpedanceTask::request_reference(std::span<const double> position, std::span<const double> velocity) {
  if (position.size() != joint_count() || velocity.size() != joint_count())
    throw ControlError(name() + " task: the reference has " + std::to_string(position.size()) + " positions and " +
                       std::to_string(velocity.size()) + " velocities, the robot has " + std::to_string(joint_count()) +
                       " joints");
  for (std::size_t i = 0; i < joint_count(); ++i) {
    if (!(position[i] >= lower_[i] && position[i] <= upper_[i]))
      throw ControlError(name() + " task: reference " + std::to_string(position[i]) + " of joint " + std::to_string(i) +
                         " must lie between " + std::to_string(lower_[i]) + " and " + std::to_string(upper_[i]));
    if (!std::isfinite(velocity[i]))
      throw ControlError(name() + " task: the velocity of joint " + std::to_string(i) + " is not finite");
  }
  std::vector<double> both(position.begin(), position.end());
  both.insert(both.end(), velocity.begin(), velocity.end());
  box_.post(both);
}

void JointImpedanceTask::start(const TaskInput& input) noexcept {
  for (std::size_t i = 0; i < joint_count(); ++i) {
    reference_[i] = std::clamp(input.position[i], lower_[i], upper_[i]);
    reference_[joint_count() + i] = 0;
  }
}

bool JointImpedanceTask::update(const TaskInput& input) noexcept {
  const std::size_t joints = joint_count();
  const std::span<double> position(reference_.data(), joints), velocity(reference_.data() + joints, joints);
  if (input.held) {
    box_.drop();
    std::ranges::fill(velocity, 0.0);
  } else if (box_.take(reference_, scratch_)) {
    age_s_ = 0;
  } else if (age_s_ < largest_age_s) {
    age_s_ += input.period_s;
    for (std::size_t i = 0; i < joints; ++i)
      position[i] = std::clamp(position[i] + input.period_s * velocity[i], lower_[i], upper_[i]);
  } else {
    std::ranges::fill(velocity, 0.0);
  }
  for (std::size_t i = 0; i < joints; ++i) {
    const double margin = std::min(end_margin, 0.1 * (upper_[i] - lower_[i]));
    const double inside =
        std::max(lower_[i] + margin - input.position[i], 0.0) - std::max(input.position[i] - upper_[i] + margin, 0.0);
    push_[i] = gains_.stiffness[i] * (position[i] - input.position[i] + end_stiffness * inside) +
               gains_.damping[i] * (velocity[i] - input.velocity[i]) +
               (input.touch_torque.empty() ? 0.0 : input.touch_torque[i]);
  }
  if (input.mass.empty()) {
    for (std::size_t i = 0; i < joints; ++i) torque_[i] = push_[i] + input.dynamics.nonlinear_effects()[i];
    return true;
  }
  if (!input.dynamics.solve_mass(push_, acceleration_of_)) return false;
  multiply(input.mass.data(), joints, joints, acceleration_of_.data(), torque_.data());
  for (std::size_t i = 0; i < joints; ++i) torque_[i] += input.bias[i];
  return true;
}

}  // namespace robotskin::control
