// SPDX-License-Identifier: Apache-2.0
#include "control/skin_reaction_task.hpp"

#include <algorithm>
#include <utility>

namespace robotskin::control {
namespace {

constexpr double gravity = 9.81;

// Of the touch's torque that a robot that stands gives way to. Against what is stronger than it can lean against it
// stiffens, the more the stronger: a blow leaves no time to bring back a centre of mass that went along with it. The
// torque left falls with the cube of the force: at twice what it bears it is an eighth, too little to turn the trunk.
double bearable_share(const TaskInput& input) noexcept {
  if (input.standing == nullptr || input.touch == nullptr) return 1;
  Vector3 force{};
  for (std::size_t body = 0; body < input.touch->matrix().body_count(); ++body)
    force = force + input.touch->wrench(body).force;
  const double bearable = SkinReactionTask::bearable_weight_share * input.dynamics.mass() * gravity;
  const double share = bearable / std::max(norm(force), bearable);
  return share * share * share * share;
}

}  // namespace

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
  const double share = bearable_share(input);
  for (std::size_t i = 0; i < joint_count(); ++i) torque_[i] = share * used[i];
  std::ranges::copy(filter_.step(torque_), torque_.begin());
  row_count_ = 0;
  for (std::size_t body = 0; body < touch_->matrix().body_count(); ++body) {
    const double force = norm(touch_->wrench(body).force);
    if (!(force > 0)) continue;
    touch_->body_torque(input.dynamics, body, touch_share(force) / force, &rows_[row_count_++ * joint_count()]);
  }
  return true;
}

}  // namespace robotskin::control
