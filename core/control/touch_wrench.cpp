// SPDX-License-Identifier: Apache-2.0
#include "control/touch_wrench.hpp"

#include <algorithm>
#include <utility>

#include "control/control_error.hpp"
#include "control/task.hpp"

namespace robotskin::control {

TouchWrench::TouchWrench(std::shared_ptr<const TouchMatrix> matrix, const SkinGains& gains)
    : matrix_(std::move(matrix)),
      activation_(gains, matrix_->cell_count()),
      magnitude_(matrix_->padded_count()),
      sorted_(matrix_->sorted_count()),
      joint_wrench_(6 * matrix_->joint_count()),
      body_wrench_(matrix_->body_count()),
      subtree_wrench_(6 * matrix_->joint_count()),
      torque_(matrix_->joint_count()) {}

bool TouchWrench::update(const TaskInput& input) noexcept {
  const bool known = input.tick != 0 && input.tick == last_tick_ && &input.dynamics == last_dynamics_;
  if (known) return last_valid_;
  last_valid_ = compute(input.dynamics, input.skin, input.share);
  last_dynamics_ = &input.dynamics;
  last_tick_ = input.tick;
  return last_valid_;
}

bool TouchWrench::compute(const RobotDynamics& dynamics, const skin::SkinState& state,
                          std::span<const float> share) noexcept {
  std::ranges::fill(torque_, 0.0);
  const std::size_t joints = joint_count();
  if (state.size() != cell_count() || share.size() != cell_count() || dynamics.joint_count() != joints) return false;

  activation_.apply(state, share.data(), magnitude_.data());
  matrix_->multiply(magnitude_.data(), sorted_.data(), joint_wrench_);

  std::ranges::fill(subtree_wrench_, 0.0);
  const double *placements = dynamics.base_from_joint().data(), *motions = dynamics.joint_motions().data();
  for (std::size_t body = 0; body < body_wrench_.size(); ++body) {
    const std::size_t joint = matrix_->body_joint(body);
    const double* base_from_joint = &placements[16 * joint];
    const double* own = &joint_wrench_[6 * joint];
    Wrench& wrench = body_wrench_[body];
    // [Cheng19 eq. 24], about the origin of the base
    wrench.force = rotate(base_from_joint, load3(own));
    wrench.moment = rotate(base_from_joint, load3(own + 3)) + cross(origin_of(base_from_joint), wrench.force);
    std::ranges::copy(wrench.force, &subtree_wrench_[6 * joint]);
    std::ranges::copy(wrench.moment, &subtree_wrench_[6 * joint + 3]);
  }
  const std::span<const int> parents = matrix_->joint_parents();
  for (std::size_t joint = joints; joint-- > 0;) {  // the wrench of a joint acts on all that it carries
    const double* wrench = &subtree_wrench_[6 * joint];
    const double* motion = &motions[6 * joint];
    // [Cheng19 eq. 25]
    torque_[joint] = (wrench[0] * motion[0] + wrench[1] * motion[1]) + (wrench[2] * motion[2] + wrench[3] * motion[3]) +
                     (wrench[4] * motion[4] + wrench[5] * motion[5]);
    if (parents[joint] != RobotModel::base)
      for (std::size_t axis = 0; axis < 6; ++axis)
        subtree_wrench_[6 * static_cast<std::size_t>(parents[joint]) + axis] += wrench[axis];
  }
  return true;
}

void TouchWrench::body_torque(const RobotDynamics& dynamics, std::size_t body, double factor,
                              double* torque) const noexcept {
  for (std::size_t i = 0; i < joint_count(); ++i) {
    if (!matrix_->carried_by(body, i)) {
      torque[i] = 0;
      continue;
    }
    const double* motion = &dynamics.joint_motions()[6 * i];
    torque[i] =
        factor * (dot(load3(motion), body_wrench_[body].force) + dot(load3(motion + 3), body_wrench_[body].moment));
  }
}

void require_joints(const TouchWrench& touch, const RobotModel& robot, const std::string& task) {
  if (touch.joint_count() != robot.joint_count())
    throw ControlError(task + " task: the touch is of a robot with " + std::to_string(touch.joint_count()) +
                       " joints, this one has " + std::to_string(robot.joint_count()));
}

}  // namespace robotskin::control
