// SPDX-License-Identifier: Apache-2.0
// The virtual robot: the full dynamic model of the robot with the inertia and friction its user wants it to have.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "model/joint_command.hpp"
#include "model/robot_dynamics.hpp"

namespace robotskin::control {

struct VirtualRobotGains {
  std::vector<double> inertia;   // (n) kg m^2 added to each joint, >= 0
  std::vector<double> friction;  // (n) Nm s/rad viscous friction B of each joint, >= 0
};

// (M(q) + I) a + C v + g + B v = tau. The friction is taken at the end of the period (semi-implicit), so any B >= 0
// is stable at any period; the integration of position with the new velocity keeps stiffness stable beside it.
class VirtualRobot {
 public:
  // Throws ControlError for gains that do not have `joint_count` finite values >= 0.
  VirtualRobot(VirtualRobotGains gains, std::size_t joint_count);
  ~VirtualRobot();
  VirtualRobot(VirtualRobot&&) noexcept;
  VirtualRobot& operator=(VirtualRobot&&) noexcept;

  // acceleration (n) rad/s^2 of (M + I + B dt) a = torque - C v - g - B v at the last update of dynamics, which was
  // made with `velocity` (n). With `mode` (n), joints that take no torques keep their speed, and their part of `torque`
  // is not looked at. False if the matrix cannot be inverted or the result is not finite.
  [[nodiscard]] bool acceleration(const RobotDynamics& dynamics, std::span<const double> velocity,
                                  std::span<const double> torque, double period_s, std::span<double> acceleration,
                                  std::span<const CommandMode> mode = {}) noexcept;

  const VirtualRobotGains& gains() const noexcept { return gains_; }

 private:
  struct Solver;
  VirtualRobotGains gains_;
  std::unique_ptr<Solver> solver_;
};

}  // namespace robotskin::control
