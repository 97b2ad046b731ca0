// SPDX-License-Identifier: Apache-2.0
#include "robot/task_cycle.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "control/control_error.hpp"

namespace robotskin::robot {
namespace {

std::size_t ticks_a_second(double period_s) {
  return static_cast<std::size_t>(std::clamp(1 / period_s, 1.0, 1e5));
}

}  // namespace

TaskCycle::TaskCycle(const RobotModel& robot, const skin::SkinModel& skin, TaskCycleGains gains,
                     const GuardLimits& limits, std::unique_ptr<control::TaskStack> stack)
    : gains_(std::move(gains)),
      dynamics_(robot),
      touch_(robot, skin, gains_.touch.measured_force()),
      robot_(robot),
      mask_(skin, gains_.fade_s),
      skin_fade_(gains_.fade_s, 1.0),
      touch_filter_(robot.joint_count(), gains_.touch_bandwidth_hz, gains_.resolver.period_s),
      stack_(std::move(stack), gains_.fade_s),
      resolver_(robot, gains_.resolver),
      guard_(robot, limits.at_period(gains_.resolver.period_s)),
      log_(ticks_a_second(gains_.resolver.period_s), robot.joint_count()),
      share_(skin.size(), 1.0F),
      fused_torque_(robot.joint_count()),
      mass_(robot.joint_count() * robot.joint_count()),
      bias_(robot.joint_count()),
      mode_(robot.joint_count()) {
  guard_.leave_out(mask_.left_out());
  if (!gains_.feet.empty()) standing_.emplace(robot, gains_.feet);
  if (stack_.stack().joint_count() != robot.joint_count())
    throw control::ControlError("task cycle: the stack is for " + std::to_string(stack_.stack().joint_count()) +
                                " joints, the robot has " + std::to_string(robot.joint_count()));
}

void TaskCycle::use_sensors(const PortSensors& sensors) {
  if (standing_) standing_->use_sensors(robot_, sensors);
}

void TaskCycle::estimate(const SensorReadings& sensors, std::int64_t now_ns, JointState& joints) noexcept {
  if (standing_) standing_known_ = standing_->update(sensors, now_ns, gains_.resolver.period_s, joints);
}

const GuardReport& TaskCycle::step(const JointState& joints, const skin::SkinState& skin, std::int64_t now_ns,
                                   JointCommand& command, const skin::SkinTorque* skin_computed_torque) noexcept {
  const double period = gains_.resolver.period_s;
  const std::int64_t deadline_ns =
      gains_.fusion_ends_s > 0 ? control::StepBudget::now_ns() + static_cast<std::int64_t>(1e9 * gains_.fusion_ends_s)
                               : 0;
  const std::size_t count = joint_count();
  const auto fits = [count](const std::vector<double>& values) {
    return values.size() == count && std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
  };
  const SafetyState state = guard_.report().state;
  const bool runs = state == SafetyState::running || state == SafetyState::degraded;
  // A robot that stands goes on balancing where another would hold still. It then feels no touch, and keeps its
  // posture.
  const bool stands = standing_.has_value() && state != SafetyState::off;
  const bool moves = runs || (stands && balances_);
  const bool settles = stands && balances_ && !runs && ran_;
  balances_ = stands;
  ran_ = runs;

  bool valid =
      fits(joints.position) && fits(joints.velocity) && command.value.size() == count && command.mode.size() == count;
  if (valid) {
    if (!moves) {  // a robot that holds still starts again from where it is, at rest
      resolver_.reset(joints);
      touch_filter_.reset();
    }
    for (std::size_t i = 0; i < count; ++i) command.mode[i] = mode_[i].load(std::memory_order_relaxed);
    resolver_.begin(joints, command.mode);
    valid = dynamics_.update(resolver_.position(), resolver_.velocity());
  }
  const std::span<const float> mask = mask_.step(period);
  const auto skin_share =
      static_cast<float>(skin_fade_.step(skin_on_.load(std::memory_order_relaxed) && (runs || !stands), period));
  for (std::size_t cell = 0; cell < share_.size(); ++cell) share_[cell] = skin_share * mask[cell];

  if (valid) valid = touch_.compute(dynamics_, skin, mask);
  if (valid) {
    const std::span<const double> touch = touch_filter_.step(touch_.torque());
    // What answers to torques is the robot with the inertia and the friction that its user wants it to have.
    std::ranges::copy(dynamics_.mass_matrix(), mass_.begin());
    const control::VirtualRobotGains& virtual_robot = gains_.resolver.virtual_robot;
    for (std::size_t i = 0; i < count; ++i) {
      mass_[i * count + i] += virtual_robot.inertia[i] + virtual_robot.friction[i] * period;
      bias_[i] = dynamics_.nonlinear_effects()[i] + virtual_robot.friction[i] * resolver_.velocity()[i] - touch[i];
    }
    const control::TaskInput input{
        .dynamics = dynamics_,
        .position = resolver_.position(),
        .velocity = resolver_.velocity(),
        .skin = skin,
        .share = share_,
        .period_s = period,
        .skin_computed_torque = skin_computed_torque,
        .source = control::unmasked_source(source_.load(std::memory_order_relaxed), mask_.whole()),
        .skin_share = skin_share,
        .tick = ++tick_,
        .deadline_ns = deadline_ns,
        .touch = &touch_,
        .standing = standing(),
        .mass = mass_,
        .bias = bias_,
        .touch_torque = touch,
        .held = stands && !runs};
    if (!moves || settles) stack_.restart(input);
    valid = stack_.compute(input, mass_, bias_, fused_torque_);
    const control::FusionReport fusion = stack_.stack().report();
    fusion_counts_.fallback_ticks += fusion.fallback ? 1 : 0;
    fusion_counts_.clock_ticks += fusion.by_clock ? 1 : 0;
    fusion_counts_.fade_limited_ticks += fusion.fade_limited ? 1 : 0;
    fusion_counts_.widened_ticks += fusion.widened ? 1 : 0;
    fusion_counts_.most_steps = std::max<std::uint64_t>(fusion_counts_.most_steps, fusion.steps);
    valid = valid && resolver_.resolve(dynamics_, fused_torque_, touch, joints, command);
  }

  // SAFETY: the guard has the last word; nothing after it changes the command.
  guard_.cap_speed(speed_cap_.load(std::memory_order_relaxed));
  const GuardReport& report =
      guard_.check(dynamics_, joints, skin, now_ns, run_.load(std::memory_order_relaxed), valid, command, standing());
  if (report.state != SafetyState::stopped || report.reason == Reason::asked)
    log_.record(now_ns, report.state, joints, fused_torque_, command);
  return report;
}

}  // namespace robotskin::robot
