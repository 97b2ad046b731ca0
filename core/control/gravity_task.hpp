// Gravity task: the torque that holds the robot still where it is.
#pragma once

#include <algorithm>
#include <span>

#include "model/robot_dynamics.hpp"

namespace robotskin::control {

// torque (n) = g(q) at the posture of the last update of dynamics; Nm.
inline void gravity_task(const RobotDynamics& dynamics, std::span<double> torque) noexcept {
  std::ranges::copy(dynamics.gravity_torque(), torque.begin());
}

}  // namespace robotskin::control
