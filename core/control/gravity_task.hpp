// SPDX-License-Identifier: Apache-2.0
// Gravity task: the torque g(q) that holds the robot still where it is.
#pragma once

#include <algorithm>

#include "control/task.hpp"
#include "model/robot_dynamics.hpp"

namespace robotskin::control {

// It stands outside of the levels: a part of gravity holds nothing.
class GravityTask final : public Task {
 public:
  explicit GravityTask(std::size_t joint_count) : Task("gravity", joint_count, 0) {}
  [[nodiscard]] bool update(const TaskInput& input) noexcept override {
    std::ranges::copy(input.dynamics.gravity_torque(), torque_.begin());
    return true;
  }
};

}  // namespace robotskin::control
