// SPDX-License-Identifier: Apache-2.0
#include "world/simulated_robot.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace robotskin::world {
namespace {

// The servo's memory is limited, so that an arm held by force does not jump when it is let go.
constexpr double lead_max = 0.05;        // rad or m, how far the velocity goal may run ahead
constexpr double error_sum_max = 0.002;  // rad s
// A joint of damping D answers to its servo as if it had D times this more inertia: that of a finger is next to none.
constexpr double damped_share_s = 0.002;
// A stop first brakes, then holds the place where the robot came to rest.
constexpr double rest_speed = 0.005;  // rad/s or m/s
constexpr double brake_max_s = 0.3;

}  // namespace

SimulatedRobot::SimulatedRobot(const mjModel& model, const mjData& data, const std::vector<int>& joints,
                               std::vector<double> effort_limit, const ServoGains& gains,
                               const Imperfections& imperfections, SensorMounting sensors, std::size_t base_joints,
                               std::uint64_t seed)
    : effort_limit_(std::move(effort_limit)),
      gains_(gains),
      command_(CommandMode::position, joints.size()),
      error_sum_(joints.size()),
      wanted_(model.nv),
      torque_(model.nv),
      measured_(joints.size()),
      encoder_step_(imperfections.encoder_bits > 0 ? 2 * std::numbers::pi / std::exp2(imperfections.encoder_bits) : 0),
      delay_(static_cast<std::size_t>(std::llround(imperfections.encoder_delay_s / model.opt.timestep))),
      sensors_(model, std::move(sensors), imperfections, seed),
      base_joints_(base_joints) {
  for (const int joint : joints) {
    position_address_.push_back(model.jnt_qposadr[joint]);
    velocity_address_.push_back(model.jnt_dofadr[joint]);
    goal_.push_back(data.qpos[position_address_.back()]);
  }
  command_.value = goal_;
  // Before the start it stood where it starts.
  for (std::size_t row = 0; row < delay_; ++row) {
    for (const int address : position_address_) late_.push_back(data.qpos[address]);
    for (const int address : velocity_address_) late_.push_back(data.qvel[address]);
  }
  measure_joints(data, 0);
}

bool SimulatedRobot::offers(CommandMode mode) const noexcept {
  if (base_joints_ > 0) return mode == CommandMode::position;
  return mode == CommandMode::position || mode == CommandMode::velocity || mode == CommandMode::torque;
}

PortStatus SimulatedRobot::read(JointState& state) noexcept {
  if (!unread_) return PortStatus::no_new_state;
  unread_ = false;
  std::copy(measured_.position.begin(), measured_.position.end(), state.position.begin());
  std::copy(measured_.velocity.begin(), measured_.velocity.end(), state.velocity.begin());
  std::copy(measured_.effort.begin(), measured_.effort.end(), state.effort.begin());
  state.stamp_ns = measured_.stamp_ns;
  return PortStatus::ok;
}

PortStatus SimulatedRobot::read_sensors(SensorReadings& readings) noexcept {
  if (!sensors_unread_) return PortStatus::no_new_state;
  sensors_unread_ = false;
  const SensorReadings& now = sensors_.readings();
  std::copy(now.imus.begin(), now.imus.end(), readings.imus.begin());
  std::copy(now.forces.begin(), now.forces.end(), readings.forces.begin());
  return PortStatus::ok;
}

PortStatus SimulatedRobot::write(const JointCommand& command) noexcept {
  if (command.value.size() != joint_count() || command.mode.size() != joint_count()) return PortStatus::refused;
  for (std::size_t i = 0; i < joint_count(); ++i)
    if (!offers(command.mode[i]) || !std::isfinite(command.value[i])) return PortStatus::refused;
  for (std::size_t i = 0; i < joint_count(); ++i) {
    if (command.mode[i] == command_.mode[i]) continue;
    // A new interface starts from where the robot is.
    goal_[i] = measured_.position[i];
    error_sum_[i] = 0;
  }
  braking_s_ = 0;
  command_left_s_ = command_life_s;
  std::ranges::copy(command.mode, command_.mode.begin());
  std::ranges::copy(command.value, command_.value.begin());
  return PortStatus::ok;
}

void SimulatedRobot::stop() noexcept {
  command_left_s_ = -1;
  braking_s_ = brake_max_s;
  std::ranges::fill(command_.mode, CommandMode::velocity);
  std::fill(command_.value.begin(), command_.value.end(), 0.0);
  std::copy(measured_.position.begin(), measured_.position.end(), goal_.begin());
  std::fill(error_sum_.begin(), error_sum_.end(), 0.0);
}

void SimulatedRobot::brake(const mjData& data, double step_s) noexcept {
  bool at_rest = true;
  for (std::size_t i = 0; i < joint_count(); ++i) {
    goal_[i] = data.qpos[position_address_[i]];
    at_rest = at_rest && (i < base_joints_ || std::abs(data.qvel[velocity_address_[i]]) < rest_speed);
  }
  braking_s_ = at_rest ? 0 : braking_s_ - step_s;
}

void SimulatedRobot::drive(const mjModel& model, mjData& data) noexcept {
  const std::size_t n = joint_count();
  if (command_left_s_ >= 0 && (command_left_s_ -= model.opt.timestep) < 0) stop();
  const double step_s = model.opt.timestep;
  if (braking_s_ > 0) brake(data, step_s);
  bool follows = false;
  for (std::size_t i = base_joints_; i < n; ++i) {  // the base's part of `wanted_` stays 0
    double& wanted = wanted_[velocity_address_[i]];
    wanted = 0;
    if (command_.mode[i] == CommandMode::torque) continue;
    follows = true;
    const double position = data.qpos[position_address_[i]], velocity = data.qvel[velocity_address_[i]];
    double goal_velocity = 0;
    if (command_.mode[i] == CommandMode::velocity) {
      goal_velocity = command_.value[i];
      goal_[i] = std::clamp(goal_[i] + goal_velocity * step_s, position - lead_max, position + lead_max);
    } else {
      goal_[i] = command_.value[i];
    }
    const double error = goal_[i] - position;
    error_sum_[i] = std::clamp(error_sum_[i] + error * step_s, -error_sum_max, error_sum_max);
    wanted = gains_.stiffness * error + gains_.damping * (goal_velocity - velocity) + gains_.integral * error_sum_[i];
  }
  if (follows) mj_mulM(&model, &data, torque_.data(), wanted_.data());
  for (std::size_t i = 0; i < n; ++i) {
    const int dof = velocity_address_[i];
    if (command_.mode[i] == CommandMode::torque)
      torque_[dof] = command_.value[i];
    else
      torque_[dof] += data.qfrc_bias[dof] + model.dof_damping[dof] * (data.qvel[dof] + damped_share_s * wanted_[dof]);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const double limited = std::clamp(torque_[velocity_address_[i]], -effort_limit_[i], effort_limit_[i]);
    measured_.effort[i] = limited;
    data.qfrc_applied[velocity_address_[i]] = limited;
  }
}

void SimulatedRobot::measure(const mjModel& model, const mjData& data, std::int64_t stamp_ns) noexcept {
  measure_joints(data, stamp_ns);
  if (sensors_.places().imus.empty() && sensors_.places().forces.empty()) return;
  sensors_.measure(model, data, stamp_ns);
  sensors_unread_ = true;
}

void SimulatedRobot::measure_joints(const mjData& data, std::int64_t stamp_ns) noexcept {
  const std::size_t n = joint_count();
  for (std::size_t i = 0; i < n; ++i) {
    double position = data.qpos[position_address_[i]], velocity = data.qvel[velocity_address_[i]];
    if (encoder_step_ > 0) position = encoder_step_ * std::round(position / encoder_step_);
    if (delay_ > 0) {
      std::swap(position, late_[2 * n * oldest_ + i]);
      std::swap(velocity, late_[2 * n * oldest_ + n + i]);
    }
    measured_.position[i] = i < base_joints_ ? not_measured : position;
    measured_.velocity[i] = i < base_joints_ ? not_measured : velocity;
  }
  if (delay_ > 0) oldest_ = (oldest_ + 1) % delay_;
  measured_.stamp_ns = stamp_ns;
  unread_ = true;
}

}  // namespace robotskin::world
