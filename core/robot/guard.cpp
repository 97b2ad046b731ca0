// SPDX-License-Identifier: Apache-2.0
#include "robot/guard.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <utility>

#include "control/acceleration_bounds.hpp"
#include "skin/skin_input.hpp"

namespace robotskin::robot {
namespace {

// Time in which a joint may come up to its velocity limit, since no servo stops accelerating at once, and in which a
// torque may bring it back inside and a braking joint to rest.
constexpr double horizon_s = control::speed_horizon_s;
// Share of the acceleration limit with which a command that was held back closes up to the one asked for.
constexpr double catch_up_share = 0.5;
// Speed below which the joints of a robot that stands are at rest: it is never quite still.
constexpr double standing_rest_speed = 0.1;
// Natural frequency with which a stopped torque-controlled robot holds its place.
constexpr double hold_rad_s = 20.0;

bool all_finite(std::span<const double> values) noexcept {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

double towards(double from, double to, double step) noexcept {
  return std::clamp(to, from - step, from + step);
}

// The speed of at most `fastest` that a joint of speed `was` may have after `share` of the horizon.
double slowing_up(double was, double speed, double fastest, double share) noexcept {
  const auto bound = [&](double sign) {
    return was * sign < fastest ? was * sign + share * (fastest - was * sign) : fastest;
  };
  return std::clamp(speed, -bound(-1), bound(1));
}

// Of a joint, M acceleration + C v + g.
double inverse_dynamics(const RobotDynamics& dynamics, std::span<const double> acceleration,
                        std::size_t joint) noexcept {
  const std::size_t joints = acceleration.size();
  double torque = dynamics.nonlinear_effects()[joint];
  for (std::size_t column = 0; column < joints; ++column)
    torque += dynamics.mass_matrix()[joint * joints + column] * acceleration[column];
  return torque;
}

}  // namespace

Guard::Guard(const RobotModel& robot, GuardLimits limits)
    : limits_(std::move(limits)),
      body_(limits_.body),
      lower_(robot.lower().begin(), robot.lower().end()),
      upper_(robot.upper().begin(), robot.upper().end()),
      velocity_limit_(robot.velocity_limit().begin(), robot.velocity_limit().end()),
      damped_(
          {std::vector<double>(robot.joint_count(), 0.0), {robot.joint_damping().begin(), robot.joint_damping().end()}},
          robot.joint_count()),
      effort_limit_(robot.effort_limit().begin(), robot.effort_limit().end()) {
  for (std::size_t i = 0; i < robot.joint_count(); ++i) actuated_.push_back(robot.actuated(i));
  const std::size_t joints = robot.joint_count();
  const auto check_joints = [joints](const char* name, const std::vector<double>& values) {
    if (values.size() != joints)
      throw GuardError(std::string("guard: ") + name + " has " + std::to_string(values.size()) +
                       " values, the robot has " + std::to_string(joints) + " joints");
    for (const double value : values)
      if (!(value > 0) || !std::isfinite(value))
        throw GuardError(std::string("guard: ") + name + " " + std::to_string(value) +
                         " must be finite and greater than 0");
  };
  const auto check_range = [](const char* name, double value, double low, double high) {
    if (!(value >= low && value <= high))
      throw GuardError(std::string("guard: ") + name + " is " + std::to_string(value) + ": it must lie between " +
                       std::to_string(low) + " and " + std::to_string(high));
  };
  check_joints("acceleration", limits_.acceleration);
  check_joints("stop_deceleration", limits_.stop_deceleration);
  check_joints("torque_rate", limits_.torque_rate);
  check_range("position_margin", limits_.position_margin, 0, 1);
  check_range("end_tolerance", limits_.end_tolerance, 0, 0.1);
  check_range("speed_share", limits_.speed_share, 0, 1);
  check_range("degraded_speed_share", limits_.degraded_speed_share, 0, limits_.speed_share);
  check_range("whole_alive_share", limits_.whole_alive_share, 0, 1);
  check_range("smallest_alive_share", limits_.smallest_alive_share, 0, limits_.whole_alive_share);
  check_range("rest_speed", limits_.rest_speed, 0, 1);
  check_range("period_s", limits_.period_s, 1e-6, 1);
  check_range("largest_switch_step", limits_.largest_switch_step, 0, 1);
  // A watchdog that waits longer than a second is none.
  const auto check_time = [&](const char* name, std::int64_t value_ns) {
    check_range(name, static_cast<double>(value_ns), 1, 1e9);
  };
  check_time("joints_timeout_ns", limits_.joints_timeout_ns);
  check_time("skin_timeout_ns", limits_.skin_timeout_ns);
  check_time("largest_cycle_ns", limits_.largest_cycle_ns);
  for (auto* values : {&last_position_, &last_velocity_, &last_torque_, &hold_, &acceleration_, &asked_position_})
    values->resize(joints);
  intervention_counts_.resize(limit_count * joints);
  last_limit_.resize(joints, Limit::acceleration);
  last_mode_.resize(joints, CommandMode::position);
}

const GuardReport& Guard::check(const RobotDynamics& dynamics, const JointState& joints, const skin::SkinState& skin,
                                std::int64_t now_ns, bool run_wanted, bool finite, JointCommand& command,
                                const control::StandingState* standing) noexcept {
  report_.conditions = conditions(joints, skin, now_ns, run_wanted, command, standing);
  if (!finite) report_.conditions &= ~std::uint16_t{command_finite};
  if (joints_known_) count_violations(joints);

  if (const Transition* row = next_transition(report_.state, report_.conditions)) {
    report_.state = row->to;
    report_.reason = row->reason;
    if (row->reason == Reason::body_limit) report_.excess = excess_;
    if (row->to == SafetyState::stopped || row->to == SafetyState::ready) at_rest_ = false;
  }
  report_.stop_port = false;
  switch (report_.state) {
    case SafetyState::off:
      report_.send = false;
      report_.stop_port = has_last_;
      has_last_ = false;
      return report_;
    case SafetyState::running:
    case SafetyState::degraded: {
      const double allowed = report_.state == SafetyState::running ? limits_.speed_share : limits_.degraded_speed_share;
      const double share = std::min(allowed, speed_cap_);
      if (limit(dynamics, joints, share, command)) ++report_.interventions;
      break;
    }
    case SafetyState::ready:
    case SafetyState::stopped:
      // SAFETY: from here the controller's command is not used; the robot comes to rest and is held, by the robot
      // itself if nothing is known of its joints, or if it would be late behind the positions that lead it to rest.
      if (!joints_known_ || command.value.size() != lower_.size() || command.mode.size() != lower_.size() ||
          port_brakes(command, standing != nullptr)) {
        report_.send = false;
        report_.stop_port = true;
        has_last_ = false;
        return report_;
      }
      // SAFETY: a robot that stands has to move to stand. Its command still keeps every limit.
      if (standing != nullptr && (report_.conditions & command_finite) != 0)
        (void)limit(dynamics, joints, limits_.speed_share, command);
      else
        brake(dynamics, joints, command);
      break;
  }
  remember(joints, command);
  report_.send = true;
  return report_;
}

std::uint16_t Guard::conditions(const JointState& joints, const skin::SkinState& skin, std::int64_t now_ns,
                                bool run_wanted, const JointCommand& command,
                                const control::StandingState* standing) noexcept {
  const std::size_t count = lower_.size();
  std::uint16_t found = 0;

  const bool shaped = joints.position.size() == count && joints.velocity.size() == count;
  const bool usable = shaped && all_finite(joints.position) && all_finite(joints.velocity);
  // A stamp from the future is no measurement, but a port may measure while it is read, after the tick has begun; and
  // one that is never_ns must not overflow the difference.
  const bool young =
      joints.stamp_ns <= now_ns + skin::sample_ahead_ns && joints.stamp_ns >= now_ns - limits_.joints_timeout_ns;
  joints_known_ = usable && young;
  if (joints_known_) {
    found |= joints_fresh;
    bool all_inside = true, rest = true;
    for (std::size_t i = 0; i < count; ++i) {
      all_inside = all_inside && inside(joints, i);
      const double rest_speed = standing != nullptr ? standing_rest_speed : limits_.rest_speed;
      rest = rest && (!actuated_[i] || std::abs(joints.velocity[i]) <= rest_speed);
    }
    found |= static_cast<std::uint16_t>((all_inside ? joints_inside : 0) | (rest ? at_rest : 0));
  }

  std::size_t alive = 0;
  for (std::size_t cell = 0; cell < skin.size(); ++cell)
    alive += skin.health[cell] == skin::Health::alive && (cell >= left_out_.size() || left_out_[cell] == 0) ? 1 : 0;
  report_.alive_share = skin.size() > 0 ? static_cast<double>(alive) / static_cast<double>(skin.size()) : 0.0;
  const bool snapshot_young = skin.time_ns <= now_ns && skin.time_ns >= now_ns - limits_.skin_timeout_ns;
  if (snapshot_young && alive > 0 && report_.alive_share >= limits_.smallest_alive_share) found |= skin_fresh;
  if (report_.alive_share >= limits_.whole_alive_share) found |= skin_whole;
  if (body_.within(skin, now_ns, excess_)) found |= contact_within;
  if (standing == nullptr || standing->support.inside_by(standing->capture_point()) >= -limits_.capture_margin_m)
    found |= balanced;

  const bool whole = command.value.size() == count && command.mode.size() == count;
  if (whole && all_finite(command.value)) found |= command_finite;
  if (last_cycle_ns_ == never_ns || now_ns - last_cycle_ns_ <= limits_.largest_cycle_ns) found |= on_time;
  last_cycle_ns_ = now_ns;
  if (run_wanted) found |= wanted;
  return found;
}

bool Guard::inside(const JointState& joints, std::size_t joint) const noexcept {
  const double beyond = std::max(joints.position[joint] - upper_[joint], lower_[joint] - joints.position[joint]);
  return beyond <= std::min(limits_.end_tolerance, 0.005 * (upper_[joint] - lower_[joint])) &&
         std::abs(joints.velocity[joint]) <= velocity_limit_[joint];
}

void Guard::count_violations(const JointState& joints) noexcept {
  if (joints.stamp_ns == last_joints_ns_) return;
  last_joints_ns_ = joints.stamp_ns;
  for (std::size_t i = 0; i < lower_.size(); ++i) {
    const bool effort_beyond = i < joints.effort.size() && std::abs(joints.effort[i]) > effort_limit_[i];
    if (inside(joints, i) && !effort_beyond) continue;
    ++report_.violations;
    return;
  }
}

void Guard::count(Limit limit, std::size_t joint) noexcept {
  ++intervention_counts_[static_cast<std::size_t>(limit) * lower_.size() + joint];
  last_limit_[joint] = limit;
  report_.limit = limit;
  report_.limited_joint = static_cast<std::int32_t>(joint);
}

bool Guard::goes_on(std::size_t joint, const JointCommand& command) const noexcept {
  return has_last_ && last_mode_[joint] == command.mode[joint];
}

bool Guard::limit(const RobotDynamics& dynamics, const JointState& joints, double speed_share,
                  JointCommand& command) noexcept {
  bool changed = false, takes_torques = false;
  for (std::size_t i = 0; i < command.value.size(); ++i) {
    if (command.mode[i] == CommandMode::torque)
      takes_torques = true;
    else if (actuated_[i])  // else nothing drives it, and nothing reads its command
      changed |= limit_motion(i, joints, speed_share, command);
  }
  if (takes_torques) changed |= limit_torques(dynamics, joints, speed_share, command);
  return changed;
}

bool Guard::limit_motion(std::size_t joint, const JointState& joints, double speed_share,
                         JointCommand& command) noexcept {
  const bool by_position = command.mode[joint] == CommandMode::position;
  const double period = limits_.period_s;
  double& value = command.value[joint];
  const double was = has_last_ ? last_velocity_[joint] : joints.velocity[joint];
  double from = joints.position[joint];
  double asked = value;
  double aim = asked;
  if (by_position) {
    if (goes_on(joint, command))
      from = last_position_[joint];
    else if (std::abs(value - from) <= limits_.largest_switch_step)
      from = value - was * period;
    asked = (value - from) / period;
    // A robot held back catches up no faster than it can end beside the controller's command, which goes on.
    const double own = goes_on(joint, command) ? (value - asked_position_[joint]) / period : asked;
    const double lag = value - from - own * period;
    const double catch_up =
        std::min(std::abs(lag) / period, std::sqrt(2 * catch_up_share * limits_.acceleration[joint] * std::abs(lag)));
    aim = own + std::copysign(catch_up, lag);
    asked_position_[joint] = value;
  }
  const double reached = towards(was, aim, limits_.acceleration[joint] * period);
  const double allowed =
      slowing_up(was, reached, speed_share * velocity_limit_[joint], std::min(1.0, period / horizon_s));
  // A joint may be only as fast as it can brake before its limit.
  const double margin = control::kept_margin(limits_.position_margin, lower_[joint], upper_[joint]);
  const double up = std::max(0.0, upper_[joint] - margin - from);
  const double down = std::max(0.0, from - lower_[joint] - margin);
  const double brake_up = std::min(std::sqrt(2 * limits_.stop_deceleration[joint] * up), up / period);
  const double brake_down = std::min(std::sqrt(2 * limits_.stop_deceleration[joint] * down), down / period);
  const double speed = std::clamp(allowed, -brake_down, brake_up);
  // Rounding of (command - from) / period is no intervention.
  if (std::abs(speed - asked) <= 1e-9) return false;
  // A command that only catches up is still held back by what held it back before.
  count(speed != allowed     ? Limit::position
        : allowed != reached ? Limit::velocity
        : reached != aim     ? Limit::acceleration
                             : last_limit_[joint],
        joint);
  value = by_position ? from + speed * period : speed;
  return true;
}

// Position and velocity limits at acceleration level, since a bound on the torque itself would forbid holding gravity.
// The acceleration is the mean one over the horizon: damped joints of little inertia, as a hand's, end it at a speed
// that their damping alone decides.
bool Guard::limit_torques(const RobotDynamics& dynamics, const JointState& joints, double speed_share,
                          JointCommand& command) noexcept {
  std::vector<double>& torque = command.value;
  const auto takes_torque = [&](std::size_t joint) { return command.mode[joint] == CommandMode::torque; };
  bool changed = false;
  if (damped_.acceleration(dynamics, joints.velocity, torque, horizon_s, acceleration_, command.mode)) {
    bool bounded = false;
    for (std::size_t i = 0; i < torque.size(); ++i) {
      if (!takes_torque(i)) continue;
      const double fastest = speed_share * velocity_limit_[i];
      const double margin = control::kept_margin(limits_.position_margin, lower_[i], upper_[i]);
      const double up = std::max(0.0, upper_[i] - margin - joints.position[i]);
      const double down = std::max(0.0, joints.position[i] - lower_[i] - margin);
      const double speed_up = std::min(fastest, std::sqrt(2 * limits_.stop_deceleration[i] * up));
      const double speed_down = std::min(fastest, std::sqrt(2 * limits_.stop_deceleration[i] * down));
      // Only a joint that is about to be too fast is held back. What a hand pushes is left out: it may let go.
      const double velocity = joints.velocity[i];
      const double high = (speed_up - velocity) / horizon_s;
      const double low = (-speed_down - velocity) / horizon_s;
      const double allowed = std::clamp(acceleration_[i], low, high);
      if (allowed != acceleration_[i]) {
        const bool beside_limit = allowed == high ? speed_up < fastest : speed_down < fastest;
        count(beside_limit ? Limit::position : Limit::velocity, i);
        acceleration_[i] = allowed;
        bounded = true;
      }
    }
    if (bounded) {
      for (std::size_t i = 0; i < torque.size(); ++i)
        if (takes_torque(i))
          torque[i] = inverse_dynamics(dynamics, acceleration_, i) +
                      damped_.gains().friction[i] * (joints.velocity[i] + horizon_s * acceleration_[i]);
      changed = true;
    }
  }
  for (std::size_t i = 0; i < torque.size(); ++i) {
    if (!takes_torque(i)) continue;
    double value = torque[i];
    if (goes_on(i, command)) value = towards(last_torque_[i], value, limits_.torque_rate[i] * limits_.period_s);
    const double slowed = value;
    value = std::clamp(value, -effort_limit_[i], effort_limit_[i]);
    if (value != torque[i]) {
      changed = true;
      count(value != slowed ? Limit::torque : Limit::torque_rate, i);
    }
    torque[i] = value;
  }
  return changed;
}

double Guard::braking_acceleration(std::size_t joint, const JointState& joints) const noexcept {
  const double most = limits_.stop_deceleration[joint];
  if (!at_rest_) return std::clamp(-joints.velocity[joint] / horizon_s, -most, most);
  const double hold =
      hold_rad_s * hold_rad_s * (hold_[joint] - joints.position[joint]) - 2 * hold_rad_s * joints.velocity[joint];
  return std::clamp(hold, -most, most);
}

bool Guard::port_brakes(const JointCommand& command, bool stands) const noexcept {
  return stops_by_port_ && !stands && report_.state == SafetyState::stopped &&
         std::ranges::all_of(command.mode, [](CommandMode mode) { return mode == CommandMode::position; });
}

void Guard::brake(const RobotDynamics& dynamics, const JointState& joints, JointCommand& command) noexcept {
  const std::size_t count = lower_.size();
  const double period = limits_.period_s;
  if (!at_rest_ && std::ranges::find(command.mode, CommandMode::torque) != command.mode.end()) {
    std::ranges::copy(joints.position, hold_.begin());
    at_rest_ = std::ranges::all_of(joints.velocity, [&](double v) { return std::abs(v) <= limits_.rest_speed; });
  }
  for (std::size_t i = 0; i < count; ++i)
    acceleration_[i] = command.mode[i] == CommandMode::torque ? braking_acceleration(i, joints) : 0.0;

  for (std::size_t i = 0; i < count; ++i) {
    if (command.mode[i] == CommandMode::torque) {
      command.value[i] = std::clamp(inverse_dynamics(dynamics, acceleration_, i), -effort_limit_[i], effort_limit_[i]);
      continue;
    }
    const double speed =
        towards(has_last_ ? last_velocity_[i] : joints.velocity[i], 0.0, limits_.stop_deceleration[i] * period);
    if (command.mode[i] == CommandMode::velocity) {
      command.value[i] = speed;
      continue;
    }
    const double from = goes_on(i, command) ? last_position_[i] : joints.position[i];
    command.value[i] = std::clamp(from + speed * period, std::min(lower_[i], from), std::max(upper_[i], from));
    asked_position_[i] = command.value[i];
  }
}

void Guard::remember(const JointState& joints, const JointCommand& command) noexcept {
  for (std::size_t i = 0; i < command.value.size(); ++i) {
    switch (command.mode[i]) {
      case CommandMode::position: {
        const double from = goes_on(i, command) ? last_position_[i] : joints.position[i];
        last_velocity_[i] = (command.value[i] - from) / limits_.period_s;
        last_position_[i] = command.value[i];
        break;
      }
      case CommandMode::velocity:
        last_velocity_[i] = command.value[i];
        break;
      case CommandMode::torque:
        last_velocity_[i] = joints.velocity[i];
        last_torque_[i] = command.value[i];
        break;
    }
    last_mode_[i] = command.mode[i];
  }
  has_last_ = true;
}

}  // namespace robotskin::robot
