// Gravity task: the torque that holds the robot still where it is.
#pragma once

#include <algorithm>
#include <span>

#include "control/task.hpp"
#include "model/robot_dynamics.hpp"

namespace robotskin::control {

// torque (n) = g(q) at the posture of the last update of dynamics; Nm.
inline void gravity_task(const RobotDynamics& dynamics, std::span<double> torque) noexcept {
  std::ranges::copy(dynamics.gravity_torque(), torque.begin());
}

// The same in a stack, where it stands outside of the levels: a part of gravity holds nothing.
class GravityTask final : public Task {
 public:
  explicit GravityTask(std::size_t joint_count) : Task("gravity", joint_count, 0) {}
  [[nodiscard]] bool update(const TaskInput& input) noexcept override {
    gravity_task(input.dynamics, torque_);
    return true;
  }
};

}  // namespace robotskin::control
