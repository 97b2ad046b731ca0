// SPDX-License-Identifier: Apache-2.0
#include "control/spline_cartesian_task.hpp"

#include <algorithm>
#include <cmath>

#include "control/control_error.hpp"

namespace robotskin::control {

SplineCartesianTask::SplineCartesianTask(const RobotModel& robot, const std::string& link, CartesianGains gains,
                                         double speed, double turn_speed)
    : CartesianTask(robot, link, gains, "spline Cartesian"), speed_(speed), turn_speed_(turn_speed) {
  for (const double value : {speed, turn_speed})
    if (!(value > 0) || !std::isfinite(value))
      throw ControlError("spline Cartesian task: speed " + std::to_string(value) +
                         " must be finite and greater than 0");
}

void SplineCartesianTask::start(const TaskInput& input) noexcept {
  CartesianTask::start(input);
  begin_ = reference_;
  way_.fill(0);
  turn_.fill(0);
  share_.hold(1);
  time_s_ = duration_s_ = 0;
}

void SplineCartesianTask::follow(const TaskInput& input, bool fresh) noexcept {
  if (fresh) {
    begin_ = reference_;
    way_ = origin_of(goal_.data()) - origin_of(begin_.data());
    turn_ = rotation_between(begin_.data(), goal_.data());
    const double length = norm(way_);
    duration_s_ = std::max(Quintic::duration_for(length, speed_), Quintic::duration_for(norm(turn_), turn_speed_));
    const Vector3 moving = {reference_velocity_[0], reference_velocity_[1], reference_velocity_[2]};
    const double along = length > 1e-9 ? std::max(dot(moving, way_) / (length * length), 0.0) : 0.0;
    share_.set(0, along, 0, 1, duration_s_);
    time_s_ = 0;
  }
  time_s_ = std::min(time_s_ + input.period_s, duration_s_ + input.period_s);
  const double share = share_.position(time_s_), rate = share_.velocity(time_s_);
  const std::array<double, 16> begin = begin_;
  turned_placement(begin.data(), share * turn_, origin_of(begin.data()) + share * way_, reference_.data());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    reference_velocity_[axis] = way_[axis] * rate;
    reference_velocity_[axis + 3] = turn_[axis] * rate;
  }
}

}  // namespace robotskin::control
