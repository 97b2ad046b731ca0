// SPDX-License-Identifier: Apache-2.0
#include "control/joint_task.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "control/control_error.hpp"

namespace robotskin::control {
void check_joint_gains(const JointGains& gains, std::size_t joint_count, const std::string& task) {
  const auto check = [joint_count, &task](const char* name, const std::vector<double>& values) {
    if (values.size() != joint_count)
      throw ControlError(task + " task: " + name + " has " + std::to_string(values.size()) + " values, the robot has " +
                         std::to_string(joint_count) + " joints");
    for (const double value : values)
      if (!std::isfinite(value) || value < 0)
        throw ControlError(task + " task: " + name + " " + std::to_string(value) + " must be finite and not negative");
  };
  check("stiffness", gains.stiffness);
  check("damping", gains.damping);
}

JointTask::JointTask(const RobotModel& robot, JointGains gains, std::string name)
    : Task(std::move(name), robot.joint_count(), robot.joint_count()),
      goal_(robot.joint_count()),
      reference_(robot.joint_count()),
      reference_velocity_(robot.joint_count()),
      lower_(robot.lower().begin(), robot.lower().end()),
      upper_(robot.upper().begin(), robot.upper().end()),
      goal_box_(robot.joint_count()),
      gain_box_(2 * robot.joint_count()) {
  const std::size_t joints = robot.joint_count();
  check_joint_gains(gains, joints, this->name());
  stiffness_ = std::move(gains.stiffness);
  damping_ = std::move(gains.damping);
  gain_ = stiffness_;
  gain_.insert(gain_.end(), damping_.begin(), damping_.end());
  asked_ = gain_;
  scratch_.resize(2 * joints);
}

void JointTask::request_reference(std::span<const double> reference) {
  if (reference.size() != joint_count())
    throw ControlError(name() + " task: the reference has " + std::to_string(reference.size()) +
                       " values, the robot has " + std::to_string(joint_count()) + " joints");
  for (std::size_t i = 0; i < joint_count(); ++i)
    if (!(reference[i] >= lower_[i] && reference[i] <= upper_[i]))
      throw ControlError(name() + " task: reference " + std::to_string(reference[i]) + " of joint " +
                         std::to_string(i) + " must lie between " + std::to_string(lower_[i]) + " and " +
                         std::to_string(upper_[i]));
  goal_box_.post(reference);
}

void JointTask::request_gains(const JointGains& gains) {
  check_joint_gains(gains, joint_count(), name());
  std::vector<double> both = gains.stiffness;
  both.insert(both.end(), gains.damping.begin(), gains.damping.end());
  gain_box_.post(both);
}

void JointTask::start(const TaskInput& input) noexcept {
  for (std::size_t i = 0; i < joint_count(); ++i) {
    goal_[i] = reference_[i] = std::clamp(input.position[i], lower_[i], upper_[i]);
    reference_velocity_[i] = 0;
  }
}

void JointTask::follow(const TaskInput&, bool fresh) noexcept {
  if (fresh) reference_ = goal_;
}

bool JointTask::update(const TaskInput& input) noexcept {
  const std::size_t joints = joint_count();
  if (input.held) goal_box_.drop();
  follow(input, !input.held && goal_box_.take(goal_, scratch_));
  (void)gain_box_.take(asked_, scratch_);
  const double share = std::min(3 * input.period_s / fade_s, 1.0);  // 95 % of the way within fade_s
  for (std::size_t i = 0; i < 2 * joints; ++i) gain_[i] += share * (asked_[i] - gain_[i]);
  std::copy_n(gain_.begin(), joints, stiffness_.begin());
  std::copy_n(gain_.begin() + static_cast<std::ptrdiff_t>(joints), joints, damping_.begin());

  std::ranges::fill(rows_, 0.0);
  row_count_ = 0;
  for (std::size_t i = 0; i < joints; ++i) {
    torque_[i] = stiffness_[i] * (reference_[i] - input.position[i]) +
                 damping_[i] * (reference_velocity_[i] - input.velocity[i]);
    if (takes_part(i)) rows_[row_count_++ * joints + i] = 1;
  }
  return true;
}

}  // namespace robotskin::control
