// SPDX-License-Identifier: Apache-2.0
#include "control/torque_resolver.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "control/acceleration_bounds.hpp"
#include "control/control_error.hpp"

namespace robotskin::control {
namespace {

// Share of a joint's velocity limit to which a learnt torque alone may bring it within `speed_horizon_s`.
constexpr double largest_bias_speed_share = 0.5;

void check(const char* name, const std::vector<double>& values, std::size_t joints) {
  if (values.size() != joints)
    throw ControlError(std::string("inner velocity loop: ") + name + " has " + std::to_string(values.size()) +
                       " values, the robot has " + std::to_string(joints) + " joints");
  for (const double value : values)
    if (!std::isfinite(value) || value < 0)
      throw ControlError(std::string("inner velocity loop: ") + name + " " + std::to_string(value) +
                         " must be finite and not negative");
}

void check_positive(const char* name, double value) {
  if (!(value > 0) || !std::isfinite(value))
    throw ControlError(std::string("torque resolver: ") + name + " is " + std::to_string(value) +
                       ": it must be finite and greater than 0");
}

}  // namespace

TorqueResolver::TorqueResolver(const RobotModel& robot, ResolverGains gains)
    : gains_(std::move(gains)),
      virtual_robot_(gains_.virtual_robot, robot.joint_count()),
      inner_loop_(gains_.inner_loop, robot.joint_count()),
      lower_(robot.lower().begin(), robot.lower().end()),
      upper_(robot.upper().begin(), robot.upper().end()),
      velocity_limit_(robot.velocity_limit().begin(), robot.velocity_limit().end()),
      joint_damping_(robot.joint_damping().begin(), robot.joint_damping().end()),
      lead_fade_(gains_.switch_time_s) {
  const std::size_t joints = robot.joint_count();
  check("proportional", gains_.inner_loop.proportional, joints);
  check("integral", gains_.inner_loop.integral, joints);
  check("derivative", gains_.inner_loop.derivative, joints);
  check_positive("period_s", gains_.period_s);
  check_positive("switch_time_s", gains_.switch_time_s);
  check_positive("largest_lead_rad", gains_.largest_lead_rad);
  for (auto* values : {&position_, &velocity_, &virtual_position_, &virtual_velocity_, &position_lead_, &velocity_lead_,
                       &position_bias_, &torque_bias_, &measured_velocity_, &surprise_, &torque_, &acceleration_})
    values->resize(joints);
  accelerated_.resize(joints);
  mode_.resize(joints, CommandMode::position);
  if (!(gains_.torque_bias_per_s >= 0 && gains_.largest_bias_effort_share >= 0))
    throw ControlError("torque resolver: torque_bias_per_s is " + std::to_string(gains_.torque_bias_per_s) +
                       " and largest_bias_effort_share is " + std::to_string(gains_.largest_bias_effort_share) +
                       ": neither may be negative");
  for (const double limit : robot.effort_limit())
    largest_torque_bias_.push_back(std::isfinite(limit) ? gains_.largest_bias_effort_share * limit : 0.0);
}

void TorqueResolver::reset(const JointState& joints) noexcept {
  for (std::size_t i = 0; i < position_.size(); ++i) reset_joint(i, joints);
}

void TorqueResolver::reset_joint(std::size_t joint, const JointState& joints) noexcept {
  virtual_position_[joint] = joints.position[joint];
  virtual_velocity_[joint] = 0;
  position_lead_[joint] = velocity_lead_[joint] = 0;
  position_bias_[joint] = torque_bias_[joint] = 0;
  accelerated_[joint] = false;
  inner_loop_.reset(joint);
}

void TorqueResolver::begin(const JointState& joints, std::span<const CommandMode> mode) noexcept {
  const double lead_share = lead_fade_.value();
  bool leads = false;
  for (std::size_t i = 0; i < mode_.size(); ++i) leads |= mode[i] == CommandMode::torque && mode_[i] != mode[i];
  if (leads) lead_fade_.set(1.0);
  for (std::size_t i = 0; i < mode_.size(); ++i) {
    const bool was_torque = mode_[i] == CommandMode::torque;
    const bool is_torque = mode[i] == CommandMode::torque;
    if (is_torque && !was_torque) {
      position_lead_[i] = virtual_position_[i] - joints.position[i];
      velocity_lead_[i] = virtual_velocity_[i] - joints.velocity[i];
    } else if (is_torque && leads) {  // the lead that it still has fades anew, from where it is
      position_lead_[i] *= lead_share;
      velocity_lead_[i] *= lead_share;
    } else if (!is_torque && was_torque) {
      reset_joint(i, joints);
      virtual_velocity_[i] = joints.velocity[i];
    } else if (mode[i] != mode_[i]) {
      // The servo's static error is removed in another way, so what was learnt does not carry over.
      inner_loop_.reset(i);
    }
    mode_[i] = mode[i];
    if (!is_torque) accelerated_[i] = false;
    position_[i] = is_torque ? joints.position[i] + lead_fade_.value() * position_lead_[i] : virtual_position_[i];
    velocity_[i] = is_torque ? joints.velocity[i] + lead_fade_.value() * velocity_lead_[i] : virtual_velocity_[i];
  }
  lead_fade_.step(false, gains_.period_s);
}

bool TorqueResolver::resolve(const RobotDynamics& dynamics, std::span<const double> fused,
                             std::span<const double> touch, const JointState& joints, JointCommand& command) noexcept {
  for (std::size_t i = 0; i < torque_.size(); ++i) torque_[i] = fused[i] + touch[i];
  learn_torque_bias(dynamics, joints);
  if (!virtual_robot_.acceleration(dynamics, velocity_, torque_, gains_.period_s, acceleration_)) return false;
  for (std::size_t i = 0; i < mode_.size(); ++i) {
    command.mode[i] = mode_[i];
    if (mode_[i] == CommandMode::torque) {
      command.value[i] = torque_command(dynamics, i, touch[i]);
      continue;
    }
    integrate(i, joints.position[i]);
    const double error = position_[i] - joints.position[i];
    if (mode_[i] == CommandMode::velocity) {
      // The joint was measured when the virtual robot was at position_, not where it is now.
      command.value[i] = inner_loop_.step(i, error, virtual_velocity_[i], joints.velocity[i], gains_.period_s);
      continue;
    }
    const double late = gains_.servo_lag_s * virtual_velocity_[i] + gains_.servo_lag_s2 * acceleration_[i];
    position_bias_[i] = std::clamp(position_bias_[i] + gains_.position_bias_per_s * error * gains_.period_s,
                                   -gains_.largest_bias_rad, gains_.largest_bias_rad);
    command.value[i] = virtual_position_[i] + late + position_bias_[i];
  }
  return true;
}

// Velocity first, then position with the new velocity: energy does not grow.
void TorqueResolver::integrate(std::size_t joint, double measured_position) noexcept {
  const double velocity = std::clamp(velocity_[joint] + gains_.period_s * acceleration_[joint], -velocity_limit_[joint],
                                     velocity_limit_[joint]);
  const double wanted = position_[joint] + gains_.period_s * velocity;
  const double low = std::max(lower_[joint], measured_position - gains_.largest_lead_rad);
  const double high = std::min(upper_[joint], measured_position + gains_.largest_lead_rad);
  virtual_position_[joint] = std::max(low, std::min(wanted, high));
  virtual_velocity_[joint] = virtual_position_[joint] == wanted ? velocity : 0.0;
}

// What the joints did in the last period and what they were asked to do differ by what the model does not know, such as
// the friction of gears. The added inertia divides stiffness by (M + I) / M against it, so a light joint would stop far
// from its goal. Summed up, the difference of velocities is no noisier than a velocity.
void TorqueResolver::learn_torque_bias(const RobotDynamics& dynamics, const JointState& joints) noexcept {
  const std::size_t count = position_.size();
  for (std::size_t i = 0; i < count; ++i)
    surprise_[i] =
        accelerated_[i] ? gains_.period_s * acceleration_[i] - (joints.velocity[i] - measured_velocity_[i]) : 0.0;
  for (std::size_t row = 0; row < count; ++row) {
    if (mode_[row] != CommandMode::torque) continue;
    if (accelerated_[row]) {
      double missing = 0;
      for (std::size_t column = 0; column < count; ++column)
        missing += dynamics.mass_matrix()[row * count + column] * surprise_[column];
      // Were there no friction after all, the bias alone must not make a joint too fast, as it soon would a light
      // wrist.
      const double lets_pass = largest_bias_speed_share * velocity_limit_[row] *
                               (dynamics.mass_matrix()[row * count + row] / speed_horizon_s + joint_damping_[row]);
      const double most = std::min(largest_torque_bias_[row], lets_pass);
      torque_bias_[row] = std::clamp(torque_bias_[row] + gains_.torque_bias_per_s * missing, -most, most);
    }
    measured_velocity_[row] = joints.velocity[row];
    accelerated_[row] = true;
  }
}

// The torque under which the real robot moves as the virtual one: M a + C v + g - touch, since the hand itself brings
// the touch, and what the model does not know.
double TorqueResolver::torque_command(const RobotDynamics& dynamics, std::size_t joint, double touch) const noexcept {
  const std::size_t joints = position_.size();
  double torque = dynamics.nonlinear_effects()[joint] - touch + torque_bias_[joint];
  for (std::size_t column = 0; column < joints; ++column)
    torque += dynamics.mass_matrix()[joint * joints + column] * acceleration_[column];
  return torque;
}

}  // namespace robotskin::control
