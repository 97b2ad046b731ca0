// SPDX-License-Identifier: Apache-2.0
#include "control/force_task.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "control/control_error.hpp"

namespace robotskin::control {

ForceTask::ForceTask(const RobotModel& robot, std::shared_ptr<TouchWrench> felt, const std::string& link,
                     ForceGains gains)
    : Task("force", robot.joint_count(), 3),
      felt_(std::move(felt)),
      gains_(gains),
      link_(robot.link_index(link)),
      joint_(static_cast<std::size_t>(robot.link_joints()[link_])),
      force_box_(3),
      jacobian_(6 * robot.joint_count()) {
  require_joints(*felt_, robot, name());
  if (robot.link_joints()[link_] == RobotModel::base)
    throw ControlError("force task: link '" + link + "' is part of the base, which does not move");
  for (const double value : {gains.integral, gains.damping, gains.largest_force})
    if (!(value > 0) || !std::isfinite(value))
      throw ControlError("force task: gain " + std::to_string(value) + " must be finite and greater than 0");
}

void ForceTask::request_force(std::span<const double> force) {
  if (force.size() != 3)
    throw ControlError("force task: the force has " + std::to_string(force.size()) + " of 3 values");
  const double size = norm({force[0], force[1], force[2]});
  if (!(size <= gains_.largest_force))
    throw ControlError("force task: a force of " + std::to_string(size) + " N must be at most " +
                       std::to_string(gains_.largest_force) + " N");
  force_box_.post(force);
}

void ForceTask::start(const TaskInput&) noexcept {
  force_ = integral_ = measured_ = {};
}

bool ForceTask::update(const TaskInput& input) noexcept {
  const std::size_t joints = joint_count();
  if (input.held) {
    force_box_.drop();
    start(input);
  } else {
    (void)force_box_.take(force_, scratch_);
  }
  if (!felt_->update(input) || !input.dynamics.link_jacobian(link_, jacobian_)) return false;
  measured_ = {};
  const TouchMatrix& matrix = felt_->matrix();
  for (std::size_t body = 0; body < matrix.body_count(); ++body)
    if (matrix.carried_by(body, joint_)) measured_ = measured_ - felt_->wrench(body).force;
  std::array<double, 3> velocity, push;
  multiply(jacobian_.data(), 3, joints, input.velocity.data(), velocity.data());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    integral_[axis] = std::clamp(integral_[axis] + input.period_s * gains_.integral * (force_[axis] - measured_[axis]),
                                 -gains_.largest_force, gains_.largest_force);
    push[axis] = std::clamp(force_[axis] + integral_[axis], -gains_.largest_force, gains_.largest_force) -
                 gains_.damping * velocity[axis];
  }
  std::ranges::fill(torque_, 0.0);
  add_transposed(jacobian_.data(), 3, joints, push.data(), torque_.data());
  std::copy_n(jacobian_.begin(), 3 * joints, rows_.begin());
  row_count_ = 3;
  return true;
}

}  // namespace robotskin::control
