#include "robot/skin_cycle.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "control/gravity_task.hpp"
#include "control/weighted_fusion.hpp"

namespace robotskin::robot {

SkinCycle::SkinCycle(const RobotModel& robot, const skin::SkinModel& skin, CycleGains gains, const GuardLimits& limits)
    : gains_(std::move(gains)),
      dynamics_(robot),
      skin_task_(robot, skin, gains_.skin),
      touch_task_(robot, skin, gains_.skin.measured_force()),
      mask_(skin, gains_.fade_s),
      skin_source_(robot.joint_count(), gains_.fade_s),
      skin_fade_(gains_.fade_s, 1.0),
      skin_filter_(robot.joint_count(), gains_.skin_bandwidth_hz, gains_.resolver.period_s),
      touch_filter_(robot.joint_count(), gains_.skin_bandwidth_hz, gains_.resolver.period_s),
      resolver_(robot, gains_.resolver),
      guard_(robot, limits.at_period(gains_.resolver.period_s)),
      lower_(robot.lower().begin(), robot.lower().end()),
      upper_(robot.upper().begin(), robot.upper().end()),
      goal_(robot.joint_count()) {
  control::check_joint_gains(gains_.joint, robot.joint_count());
  for (auto* values : {&reference_, &joint_torque_, &gravity_torque_, &host_skin_torque_, &skin_torque_, &touch_torque_,
                       &fused_torque_})
    values->resize(robot.joint_count());
}

bool SkinCycle::request_goal(std::span<const double> goal) noexcept {
  if (goal.size() != goal_.size()) return false;
  for (std::size_t i = 0; i < goal.size(); ++i)
    if (!(goal[i] >= lower_[i] && goal[i] <= upper_[i])) return false;
  for (std::size_t i = 0; i < goal.size(); ++i) goal_[i].store(goal[i], std::memory_order_relaxed);
  goal_given_.store(true, std::memory_order_release);
  return true;
}

void SkinCycle::follow_goal(const JointState& joints) noexcept {
  const SafetyState state = guard_.report().state;
  if (state != SafetyState::running && state != SafetyState::degraded) {
    // Whoever holds still starts again from where it is, at rest.
    resolver_.reset(joints);
    skin_filter_.reset();
    touch_filter_.reset();
    for (std::size_t i = 0; i < reference_.size(); ++i)
      reference_[i] = std::clamp(joints.position[i], lower_[i], upper_[i]);
    return;
  }
  if (!goal_given_.load(std::memory_order_acquire)) return;
  const double step = gains_.goal_speed * gains_.resolver.period_s;
  for (std::size_t i = 0; i < reference_.size(); ++i)
    reference_[i] = std::clamp(goal_[i].load(std::memory_order_relaxed), reference_[i] - step, reference_[i] + step);
}

const GuardReport& SkinCycle::step(const JointState& joints, const skin::SkinState& skin, std::int64_t now_ns,
                                   JointCommand& command, const skin::SkinTorque* own_torque) noexcept {
  const double period = gains_.resolver.period_s;
  const CommandMode mode = mode_.load(std::memory_order_relaxed);
  const std::size_t count = joint_count();
  const auto fits = [count](const std::vector<double>& values) {
    return values.size() == count && std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
  };
  bool valid = fits(joints.position) && fits(joints.velocity) && command.value.size() == count;

  if (valid) {
    follow_goal(joints);
    resolver_.begin(joints, mode);
    command.mode = mode;
    valid = dynamics_.update(resolver_.position(), resolver_.velocity());
  }
  const std::span<const float> share = mask_.step(period);
  if (valid) {
    control::joint_task(gains_.joint, reference_, resolver_.position(), resolver_.velocity(), joint_torque_);
    control::gravity_task(dynamics_, gravity_torque_);
    valid = skin_task_.compute(dynamics_, skin, share, host_skin_torque_) &&  // (14) to (17) by (22) to (25)
            touch_task_.compute(dynamics_, skin, share, touch_torque_);
    const auto source = control::unmasked_source(source_.load(std::memory_order_relaxed), mask_.whole());
    std::ranges::copy(skin_source_.step(source, host_skin_torque_, own_torque, period), skin_torque_.begin());
  }
  const double skin_weight = skin_fade_.step(skin_on_.load(std::memory_order_relaxed), period);
  if (valid) {
    control::weighted_fusion(
        {{1.0, joint_torque_}, {1.0, gravity_torque_}, {skin_weight, skin_filter_.step(skin_torque_)}},
        fused_torque_);  // (18)
    valid = resolver_.resolve(dynamics_, fused_torque_, touch_filter_.step(touch_torque_), joints, command);
  }

  // SAFETY: the guard has the last word; nothing after it changes the command.
  return guard_.check(dynamics_, joints, skin, now_ns, run_.load(std::memory_order_relaxed), valid, command);
}

}  // namespace robotskin::robot
