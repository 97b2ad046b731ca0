// SPDX-License-Identifier: Apache-2.0
// The guard: the last word before the robot. Nothing after it changes a command.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "control/standing_state.hpp"
#include "control/virtual_robot.hpp"
#include "model/joint_command.hpp"
#include "model/joint_state.hpp"
#include "model/robot_dynamics.hpp"
#include "model/robot_model.hpp"
#include "robot/body_limits.hpp"
#include "robot/guard_error.hpp"
#include "robot/safety_table.hpp"
#include "skin/skin_state.hpp"

namespace robotskin::robot {

// Position, velocity and torque limits are the robot model's; these are the others.
struct GuardLimits {
  std::vector<double> acceleration;  // (n) rad/s^2, of commands
  std::vector<double>
      stop_deceleration;            // (n) rad/s^2, of a controlled stop, and what braking before a limit counts on
  std::vector<double> torque_rate;  // (n) Nm/s
  // rad (m) kept from the position limits by commands, but no more than 5 % of the room between them.
  double position_margin = 0.02;
  // rad (m) by which a joint may be measured beyond a position limit, but no more than 0.5 % of the room between them:
  // a hand that presses a joint onto its end bends that end.
  double end_tolerance = 0.002;
  double speed_share = 0.95;           // share of the velocity limits commands may use
  double degraded_speed_share = 0.25;  // the same while degraded
  double largest_switch_step = 0.05;  // rad between a position command and the joint when that interface is switched to
  double rest_speed = 0.01;           // rad/s below which a joint is at rest
  double smallest_alive_share = 0.5;  // share of cells alive below which the skin is lost
  double whole_alive_share = 0.9;     // share of cells alive from which the skin is whole
  std::int64_t joints_timeout_ns = 20'000'000;
  std::int64_t skin_timeout_ns = 250'000'000;  // age of the snapshot: two heartbeats of a section unit missed
  std::int64_t largest_cycle_ns = 20'000'000;  // time between two cycles
  double period_s = 0.001;
  BodyLimits body;  // none: no limits of contact
  // How far outside the soles the capture point of a robot that stands may be before it counts as falling.
  double capture_margin_m = 0.02;

  // The same limits in a cycle of this period.
  GuardLimits at_period(double cycle_period_s) const {
    GuardLimits limits = *this;
    limits.period_s = cycle_period_s;
    return limits;
  }
};

// Which limit made the guard change a command.
enum class Limit : std::uint8_t { position, velocity, acceleration, torque, torque_rate };
inline constexpr std::size_t limit_count = 5;

struct GuardReport {
  SafetyState state = SafetyState::off;
  Reason reason = Reason::none;  // why the state was last changed; stays while stopped or degraded
  std::uint16_t conditions = 0;  // of this cycle
  bool send = false;             // the command may go to the robot
  bool stop_port = false;        // call RobotPort::stop: it cannot be led from here, or stops sooner; never with send
  std::uint64_t interventions = 0;  // cycles in which the guard changed a running controller's command
  Limit limit = Limit::position;    // that the last intervention kept,
  std::int32_t limited_joint = -1;  // and of which joint; -1: there was none
  std::uint64_t violations = 0;  // cycles in which the measured robot was beyond a position, velocity or torque limit
  double alive_share = 0;        // share of cells alive
  BodyExcess excess;             // the contact that led to Reason::body_limit; stays while stopped
};

class Guard {
 public:
  // Throws GuardError for limits of the wrong count, not finite or out of order.
  Guard(const RobotModel& robot, GuardLimits limits);

  // (N) 1 where a cell counts as not alive; looked at every cycle, so it must stay where it is. Empty: none.
  void leave_out(std::span<const std::uint8_t> cells) noexcept { left_out_ = cells; }

  // Decides on this cycle's command, which `finite` says the controller could compute, and rewrites it where it has
  // to: within limits while running, a hold while ready, a controlled stop while stopped. Of a robot that stands
  // (`standing`) the command is within limits in these states, too, since one that holds still falls. `dynamics` was
  // updated in this cycle, with the measured state of joints that take torques. Never allocates or throws.
  const GuardReport& check(const RobotDynamics& dynamics, const JointState& joints, const skin::SkinState& skin,
                           std::int64_t now_ns, bool run_wanted, bool finite, JointCommand& command,
                           const control::StandingState* standing = nullptr) noexcept;

  // Share of the velocity limits, 0 to 1, that a running controller's commands may use besides what the limits allow.
  void cap_speed(double share) noexcept { speed_cap_ = share; }

  // A stop of a robot that takes positions is left to its port (RobotPort::smooths_positions).
  void leave_stops_to_port(bool leave) noexcept { stops_by_port_ = leave; }

  const GuardReport& report() const noexcept { return report_; }
  const GuardLimits& limits() const noexcept { return limits_; }
  // (limit_count, n) cycles in which each limit of each joint changed a running controller's command.
  const std::vector<std::uint64_t>& intervention_counts() const noexcept { return intervention_counts_; }

 private:
  std::uint16_t conditions(const JointState& joints, const skin::SkinState& skin, std::int64_t now_ns, bool run_wanted,
                           const JointCommand& command, const control::StandingState* standing) noexcept;
  bool inside(const JointState& joints, std::size_t joint) const noexcept;
  void count_violations(const JointState& joints) noexcept;
  bool limit(const RobotDynamics& dynamics, const JointState& joints, double speed_share,
             JointCommand& command) noexcept;
  bool limit_motion(std::size_t joint, const JointState& joints, double speed_share, JointCommand& command) noexcept;
  bool limit_torques(const RobotDynamics& dynamics, const JointState& joints, double speed_share,
                     JointCommand& command) noexcept;
  void count(Limit limit, std::size_t joint) noexcept;
  void brake(const RobotDynamics& dynamics, const JointState& joints, JointCommand& command) noexcept;
  double braking_acceleration(std::size_t joint, const JointState& joints) const noexcept;
  bool goes_on(std::size_t joint, const JointCommand& command) const noexcept;
  void remember(const JointState& joints, const JointCommand& command) noexcept;
  bool port_brakes(const JointCommand& command, bool stands) const noexcept;

  std::span<const std::uint8_t> left_out_;
  GuardLimits limits_;
  BodyMonitor body_;
  BodyExcess excess_;  // of this cycle
  std::vector<double> lower_, upper_, velocity_limit_;
  control::VirtualRobot damped_;  // the robot with the damping of its joints
  std::vector<double> effort_limit_;
  std::vector<bool> actuated_;
  GuardReport report_;
  std::vector<std::uint64_t> intervention_counts_;  // (limit_count, n)
  std::vector<Limit> last_limit_;                   // (n) that held a joint's command back last
  double speed_cap_ = 1;
  bool has_last_ = false;      // something was sent, in last_mode_
  bool joints_known_ = false;  // the joint state of this cycle can be used
  bool stops_by_port_ = false;
  bool at_rest_ = false;  // a stop has come to rest, hold_ is where
  std::int64_t last_cycle_ns_ = never_ns;
  std::int64_t last_joints_ns_ = never_ns;
  std::vector<CommandMode> last_mode_;                               // (n)
  std::vector<double> last_position_, last_velocity_, last_torque_;  // (n) as commanded
  std::vector<double> asked_position_;                               // (n) of the last cycle, before it was limited
  std::vector<double> hold_;                                         // (n) rad
  std::vector<double> acceleration_;                                 // (n)
};

}  // namespace robotskin::robot
