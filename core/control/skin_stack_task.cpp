#include "control/skin_stack_task.hpp"

#include <algorithm>

#include "control/control_error.hpp"
#include "control/spatial.hpp"

namespace robotskin::control {
namespace {

std::size_t moving_joint_of(const RobotModel& robot, const std::string& link) {
  const int joint = robot.link_joints()[robot.link_index(link)];
  if (joint == RobotModel::base)
    throw ControlError("skin Cartesian task: link '" + link + "' is part of the base, which does not move");
  return static_cast<std::size_t>(joint);
}

}  // namespace

SkinReactionTask::SkinReactionTask(const RobotModel& robot, const skin::SkinModel& skin, const SkinGains& gains,
                                   double bandwidth_hz, double period_s, double own_scale)
    : Task("skin", robot.joint_count(), robot.joint_count()),
      skin_task_(robot, skin, gains),
      bodies_(robot, skin),
      source_(robot.joint_count(), source_fade_s),
      filter_(robot.joint_count(), bandwidth_hz, period_s),
      own_scale_(own_scale),
      asked_(robot.joint_count()) {}

bool SkinReactionTask::update(const TaskInput& input) noexcept {
  if (!skin_task_.compute(input.dynamics, input.skin, input.share, asked_)) return false;
  const std::span<const double> used =
      source_.step(input.source, asked_, input.own_torque, input.period_s, own_scale_ * input.skin_share);
  std::ranges::copy(filter_.step(used), torque_.begin());
  row_count_ = 0;
  for (std::size_t body = 0; body < bodies_.count(); ++body) {
    const auto wrench = bodies_.wrench(input.dynamics, skin_task_.body_wrenches(), body);
    const double force = norm(wrench.force);
    if (!(force > 0)) continue;
    bodies_.torque(input.dynamics, body, wrench, touch_share(force) / force, &rows_[row_count_++ * joint_count()]);
  }
  return true;
}

SkinCartesianTask::SkinCartesianTask(const RobotModel& robot, const skin::SkinModel& skin, const SkinGains& gains,
                                     const std::string& link, double bandwidth_hz, double period_s)
    : Task("skin Cartesian", robot.joint_count(), 3),
      skin_task_(robot, skin, gains),
      bodies_(robot, skin),
      filter_(3, bandwidth_hz, period_s),
      link_(robot.link_index(link)),
      link_joint_(moving_joint_of(robot, link)),
      jacobian_(6 * robot.joint_count()),
      ignored_(robot.joint_count()) {
  limb_.resize(bodies_.count());
  for (std::size_t body = 0; body < bodies_.count(); ++body) {
    for (int i = static_cast<int>(link_joint_); i != RobotModel::base; i = robot.joint_parents()[i])
      limb_[body] = limb_[body] || bodies_.joint(body) == static_cast<std::size_t>(i);
    limb_[body] = limb_[body] || bodies_.carried_by(body, link_joint_);
  }
}

bool SkinCartesianTask::update(const TaskInput& input) noexcept {
  if (!skin_task_.compute(input.dynamics, input.skin, input.share, ignored_) ||
      !input.dynamics.link_jacobian(link_, jacobian_))
    return false;
  force_ = {};
  for (std::size_t body = 0; body < bodies_.count(); ++body)
    if (limb_[body]) force_ = sum(force_, bodies_.wrench(input.dynamics, skin_task_.body_wrenches(), body).force);
  const std::span<const double> force = filter_.step(force_);
  std::ranges::fill(torque_, 0.0);
  add_transposed(jacobian_.data(), 3, joint_count(), force.data(), torque_.data());
  const double share = touch_share(norm({force[0], force[1], force[2]}));
  row_count_ = share > 0 ? 3 : 0;
  for (std::size_t i = 0; i < row_count_ * joint_count(); ++i) rows_[i] = share * jacobian_[i];
  return true;
}

}  // namespace robotskin::control
