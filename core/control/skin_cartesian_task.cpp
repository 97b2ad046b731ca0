// SPDX-License-Identifier: Apache-2.0
#include "control/skin_cartesian_task.hpp"

#include <algorithm>
#include <utility>

#include "control/control_error.hpp"

namespace robotskin::control {

SkinCartesianTask::SkinCartesianTask(const RobotModel& robot, std::shared_ptr<TouchWrench> touch,
                                     const std::string& link, double bandwidth_hz, double period_s)
    : Task("skin Cartesian", robot.joint_count(), 3),
      touch_(std::move(touch)),
      filter_(3, bandwidth_hz, period_s),
      link_(robot.link_index(link)),
      jacobian_(6 * robot.joint_count()) {
  require_joints(*touch_, robot, name());
  const TouchMatrix& matrix = touch_->matrix();
  const int link_joint = robot.link_joints()[link_];
  if (link_joint == RobotModel::base)
    throw ControlError("skin Cartesian task: link '" + link + "' is part of the base, which does not move");
  limb_.resize(matrix.body_count());
  for (std::size_t body = 0; body < matrix.body_count(); ++body) {
    for (int i = link_joint; i != RobotModel::base; i = robot.joint_parents()[static_cast<std::size_t>(i)])
      limb_[body] = limb_[body] || matrix.body_joint(body) == static_cast<std::size_t>(i);
    limb_[body] = limb_[body] || matrix.carried_by(body, static_cast<std::size_t>(link_joint));
  }
}

bool SkinCartesianTask::update(const TaskInput& input) noexcept {
  if (!touch_->update(input) || !input.dynamics.link_jacobian(link_, jacobian_)) return false;
  force_ = {};
  for (std::size_t body = 0; body < limb_.size(); ++body)
    if (limb_[body]) force_ = force_ + touch_->wrench(body).force;
  const std::span<const double> force = filter_.step(force_);
  std::ranges::fill(torque_, 0.0);
  add_transposed(jacobian_.data(), 3, joint_count(), force.data(), torque_.data());
  const double share = touch_share(norm({force[0], force[1], force[2]}));
  row_count_ = share > 0 ? 3 : 0;
  for (std::size_t i = 0; i < row_count_ * joint_count(); ++i) rows_[i] = share * jacobian_[i];
  return true;
}

}  // namespace robotskin::control
