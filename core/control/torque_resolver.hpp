// SPDX-License-Identifier: Apache-2.0
// Torque resolver: one fused torque in, a command for whichever of the three interfaces the robot has out.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "control/fade.hpp"
#include "control/inner_velocity_loop.hpp"
#include "control/virtual_robot.hpp"
#include "model/joint_command.hpp"
#include "model/joint_state.hpp"
#include "model/robot_dynamics.hpp"
#include "model/robot_model.hpp"

namespace robotskin::control {

struct ResolverGains {
  VirtualRobotGains virtual_robot;
  InnerLoopGains inner_loop;
  double period_s = 0.001;
  double switch_time_s = 0.25;     // how long a change of interface is blended
  double largest_lead_rad = 0.2;   // how far the virtual robot may run ahead of the real one
  double position_bias_per_s = 2;  // 1/s: how fast the position interface removes the servo's static error
  double largest_bias_rad = 0.02;  // bound of that correction
  double torque_bias_per_s = 20;   // 1/s: how fast the torque interface makes up for what the model does not know
  double largest_bias_effort_share =
      0.05;  // bound of that torque, of each joint's effort limit: gears rub with as much
  // The robot's position servo follows as q + lag_s dq/dt + lag_s2 d2q/dt2 = command; commands lead by as much.
  double servo_lag_s = 0;
  double servo_lag_s2 = 0;
};

// All three interfaces obey the same equation, (M + I) a + C v + B v + g = fused + touch: a virtual robot with the
// position and velocity interfaces, which cannot feel the hand mechanically and so receives the measured touch; the
// real one with the torque interface. Each joint may have an interface of its own. One period is begin, update of the
// dynamics at position() and velocity(), the tasks, resolve.
class TorqueResolver {
 public:
  // Throws ControlError for gains of the wrong count or that are not finite.
  TorqueResolver(const RobotModel& robot, ResolverGains gains);

  // Puts the virtual robot where the real one is, at rest.
  void reset(const JointState& joints) noexcept;

  // Chooses the state on which the tasks act: the virtual robot's for joints with the position or velocity interface,
  // the real one's for those with the torque interface. A change of mode (n) goes on from the state of the mode before,
  // so that the command of a frozen robot does not jump.
  void begin(const JointState& joints, std::span<const CommandMode> mode) noexcept;
  std::span<const double> position() const noexcept { return position_; }  // (n) rad
  std::span<const double> velocity() const noexcept { return velocity_; }  // (n) rad/s

  // fused (n) tau_Sigma of [Cheng19 eq. 18] and touch (n) measured contact torque, Nm. Fills the command, which has n
  // joints. False, with the command left as it was, if no finite command follows.
  [[nodiscard]] bool resolve(const RobotDynamics& dynamics, std::span<const double> fused,
                             std::span<const double> touch, const JointState& joints, JointCommand& command) noexcept;

  const ResolverGains& gains() const noexcept { return gains_; }

 private:
  void integrate(std::size_t joint, double measured_position) noexcept;
  void reset_joint(std::size_t joint, const JointState& joints) noexcept;
  double torque_command(const RobotDynamics& dynamics, std::size_t joint, double touch) const noexcept;
  void learn_torque_bias(const RobotDynamics& dynamics, const JointState& joints) noexcept;

  ResolverGains gains_;
  VirtualRobot virtual_robot_;
  InnerVelocityLoop inner_loop_;
  std::vector<double> lower_, upper_, velocity_limit_;       // (n) bounds of the virtual robot
  std::vector<double> joint_damping_;                        // (n) Nm s/rad, of the robot's own joints
  std::vector<double> largest_torque_bias_;                  // (n) Nm
  std::vector<double> position_, velocity_;                  // (n) the state on which the tasks act
  std::vector<double> virtual_position_, virtual_velocity_;  // (n) q_v, and its rate
  std::vector<double> position_lead_, velocity_lead_;        // (n) virtual minus real when torque mode was entered
  std::vector<double> position_bias_;                        // (n) rad
  std::vector<double> torque_bias_;                          // (n) Nm
  std::vector<double> measured_velocity_, surprise_;         // (n) rad/s of the period before; (n) rad/s
  std::vector<bool> accelerated_;                            // (n) the period before gave a torque for acceleration_
  std::vector<double> torque_, acceleration_;                // (n)
  Fade lead_fade_;
  std::vector<CommandMode> mode_;  // (n)
};

}  // namespace robotskin::control
