// SPDX-License-Identifier: Apache-2.0
#include "control/balance_task.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "control/control_error.hpp"
#include "control/low_pass.hpp"
#include "control/touch_wrench.hpp"

namespace robotskin::control {
namespace {

constexpr double gravity = 9.81;
constexpr double least_height_m = 0.1;
constexpr double largest_shift_m = 0.25;  // more than any robot can stand against
// Without the feet's forces: how fast the centre of mass follows the lean, and at most.
constexpr double lean_rate = 2.5, lean_speed = 0.1;
constexpr double begin_s = 0.5;  // in which the task comes up to its full speed

}  // namespace

BalanceTask::BalanceTask(const RobotModel& robot, BalanceGains gains)
    : Task("balance", robot.joint_count(), 2, Asks::acceleration), gains_(gains), jacobian_(3 * robot.joint_count()) {
  for (const double value : {gains.lean, gains.lean_hz, gains.capture, gains.admittance, gains.margin_m,
                             gains.largest_speed, gains.largest_lean_m, gains.lean_feedforward, gains.largest_lead_m,
                             gains.stiffness, gains.damping, gains.touch_hz, gains.rest_hz})
    if (!(value >= 0) || !std::isfinite(value))
      throw ControlError("balance task: gain " + std::to_string(value) + " must be finite and not negative");
}

void BalanceTask::start(const TaskInput& input) noexcept {
  const Vector3 centre = input.dynamics.centre_of_mass();
  wanted_ = {centre[0], centre[1]};
  speed_ = {};
  begun_s_ = 0;
}

// The shift of the point of balance by all that touches the skin.
Vector2 BalanceTask::felt(const TaskInput& input, const Vector3& centre) const noexcept {
  if (input.touch == nullptr || !gains_.by_skin) return {};
  Vector3 force{}, moment{};
  for (std::size_t body = 0; body < input.touch->matrix().body_count(); ++body) {
    force = force + input.touch->wrench(body).force;
    moment = moment + input.touch->wrench(body).moment;
  }
  const Vector3 about = moment - cross({centre[0], centre[1], 0}, force);
  const double weight = input.dynamics.mass() * gravity;
  return {std::clamp(about[1] / weight, -largest_shift_m, largest_shift_m),
          std::clamp(-about[0] / weight, -largest_shift_m, largest_shift_m)};
}

void BalanceTask::follow(const TaskInput& input) noexcept {
  const StandingState& state = *input.standing;
  const double period = input.period_s;
  const Vector2 felt_now = felt(input, state.centre_of_mass);
  const Vector2 capture = state.capture_point(), centre = state.support.centre();
  const bool by_feet = gains_.by_feet && state.forces_count;
  const double rate = std::sqrt(gravity / std::max(state.centre_of_mass[2], least_height_m));
  Vector2 goal{}, goal_speed{};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    skin_shift_[axis] += low_pass_share(gains_.touch_hz, period) * (felt_now[axis] - skin_shift_[axis]);
    // What pushes and is not felt, such as between cells, shows in the feet, where the robot's own motion hides it.
    const double unfelt = by_feet ? state.zmp[axis] - state.centre_of_mass[axis] - skin_shift_[axis] : 0.0;
    rest_[axis] +=
        low_pass_share(gains_.rest_hz, period) * (std::clamp(unfelt, -largest_shift_m, largest_shift_m) - rest_[axis]);
    shift_[axis] = skin_shift_[axis] + rest_[axis];
    const double before = std::clamp(gains_.lean * slow_[axis], -gains_.largest_lean_m, gains_.largest_lean_m);
    slow_[axis] += low_pass_share(gains_.lean_hz, period) * (shift_[axis] - slow_[axis]);
    const double lean = std::clamp(gains_.lean * slow_[axis], -gains_.largest_lean_m, gains_.largest_lean_m);
    goal[axis] = centre[axis] - lean;
    goal_speed[axis] = gains_.lean_feedforward * (before - lean) / period;
    pressed_[axis] =
        goal[axis] + shift_[axis] + gains_.capture * (capture[axis] - goal[axis]) - goal_speed[axis] / rate;
  }
  pressed_ = state.support.clipped(pressed_, gains_.margin_m);
  begun_s_ += period;
  const double share = std::min(begun_s_ / begin_s, 1.0);
  for (std::size_t axis = 0; axis < 2; ++axis) {
    // What the soles allow of the lean's own speed.
    const double allowed = rate * (capture[axis] + shift_[axis] - pressed_[axis]);
    const double ahead = std::clamp(allowed, std::min(goal_speed[axis], 0.0), std::max(goal_speed[axis], 0.0));
    speed_[axis] = by_feet ? std::clamp(ahead + gains_.admittance * (state.zmp[axis] - pressed_[axis]),
                                        -gains_.largest_speed, gains_.largest_speed)
                           : std::clamp(lean_rate * (goal[axis] - wanted_[axis]), -lean_speed, lean_speed);
    speed_[axis] *= share;
    wanted_[axis] =
        state.centre_of_mass[axis] + std::clamp(wanted_[axis] + period * speed_[axis] - state.centre_of_mass[axis],
                                                -gains_.largest_lead_m, gains_.largest_lead_m);
  }
}

bool BalanceTask::update(const TaskInput& input) noexcept {
  const std::size_t joints = joint_count();
  if (!input.dynamics.centre_of_mass_jacobian(jacobian_)) return false;
  if (input.standing != nullptr) follow(input);
  row_count_ = 2;
  std::copy_n(jacobian_.begin(), 2 * joints, rows_.begin());
  const Vector3 centre = input.dynamics.centre_of_mass();
  for (std::size_t axis = 0; axis < 2; ++axis) {
    double speed = 0;
    for (std::size_t k = 0; k < joints; ++k) speed += jacobian_[axis * joints + k] * input.velocity[k];
    acceleration_[axis] = gains_.stiffness * (wanted_[axis] - centre[axis]) + gains_.damping * (speed_[axis] - speed);
  }
  return true;
}

}  // namespace robotskin::control
