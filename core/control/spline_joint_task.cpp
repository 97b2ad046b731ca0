// SPDX-License-Identifier: Apache-2.0
#include "control/spline_joint_task.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "control/control_error.hpp"

namespace robotskin::control {

SplineJointTask::SplineJointTask(const RobotModel& robot, JointGains gains, double speed)
    : JointTask(robot, std::move(gains), "spline joint"), speed_(speed), splines_(robot.joint_count()) {
  if (!(speed > 0) || !std::isfinite(speed))
    throw ControlError("spline joint task: speed " + std::to_string(speed) + " must be finite and greater than 0");
}

void SplineJointTask::start(const TaskInput& input) noexcept {
  JointTask::start(input);
  for (std::size_t i = 0; i < joint_count(); ++i) splines_[i].hold(reference_[i]);
  time_s_ = duration_s_ = 0;
}

void SplineJointTask::follow(const TaskInput& input, bool fresh) noexcept {
  if (fresh) {
    double duration = 0;
    for (std::size_t i = 0; i < joint_count(); ++i)
      if (takes_part(i)) duration = std::max(duration, Quintic::duration_for(goal_[i] - reference_[i], speed_));
    for (std::size_t i = 0; i < joint_count(); ++i)
      splines_[i].set(splines_[i].position(time_s_), splines_[i].velocity(time_s_), splines_[i].acceleration(time_s_),
                      goal_[i], duration);
    time_s_ = 0;
    duration_s_ = duration;
  }
  time_s_ = std::min(time_s_ + input.period_s, duration_s_ + input.period_s);
  for (std::size_t i = 0; i < joint_count(); ++i) {
    reference_[i] = splines_[i].position(time_s_);
    reference_velocity_[i] = splines_[i].velocity(time_s_);
  }
}

}  // namespace robotskin::control
