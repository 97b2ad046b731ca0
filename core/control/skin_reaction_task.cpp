// SPDX-License-Identifier: Apache-2.0
#include "control/skin_reaction_task.hpp"

#include <algorithm>
#include <utility>

namespace robotskin::control {

SkinReactionTask::SkinReactionTask(std::shared_ptr<TouchWrench> touch, double bandwidth_hz, double period_s,
                                   double own_scale)
    : Task("skin", touch->joint_count(), touch->joint_count()),
      touch_(std::move(touch)),
      source_(joint_count(), source_fade_s),
      filter_(joint_count(), bandwidth_hz, period_s),
      own_scale_(own_scale) {}

bool SkinReactionTask::update(const TaskInput& input) noexcept {
  if (!touch_->update(input)) return false;
  const std::span<const double> used = source_.step(input.source, touch_->torque(), input.skin_computed_torque,
                                                    input.period_s, own_scale_ * input.skin_share);
  std::ranges::copy(filter_.step(used), torque_.begin());
  row_count_ = 0;
  for (std::size_t body = 0; body < touch_->matrix().body_count(); ++body) {
    const double force = norm(touch_->wrench(body).force);
    if (!(force > 0)) continue;
    touch_->body_torque(input.dynamics, body, touch_share(force) / force, &rows_[row_count_++ * joint_count()]);
  }
  return true;
}

}  // namespace robotskin::control
