// SPDX-License-Identifier: Apache-2.0
// Self-collision avoidance: pushes bodies apart that come too near to each other, and lays claim to their approach.
#pragma once

#include <span>
#include <vector>

#include "control/task.hpp"
#include "model/self_distance.hpp"

namespace robotskin::control {

struct SelfCollisionGains {
  double safe_m = 0.05;     // the task begins to act at this distance
  double stiffness = 2000;  // N/m of what is missing to it
  double damping = 50;      // N s/m against coming nearer
};

// With x, 0 at the safe distance and 1 at contact and beyond, and a = x^2 (3 - 2 x): each pair of bodies claims the row
// a d', the rate of its distance, and is pushed apart by a (stiffness (safe - d) - damping d').
class SelfCollisionTask final : public Task {
 public:
  // Throws ControlError for gains that are not finite and positive.
  SelfCollisionTask(const RobotModel& robot, SelfDistance distances, SelfCollisionGains gains);
  [[nodiscard]] bool update(const TaskInput& input) noexcept override;

  std::span<const NearPair> near() const noexcept { return near_; }  // of the last update
  std::size_t measured() const noexcept { return distances_.measured(); }

 private:
  SelfDistance distances_;
  SelfCollisionGains gains_;
  std::vector<int> parent_;
  std::span<const NearPair> near_;
};

}  // namespace robotskin::control
