// SPDX-License-Identifier: Apache-2.0
// Feet that stand: they stay where they stood when the task began, and lie flat on the ground as it is.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "control/task.hpp"
#include "model/foot.hpp"
#include "model/robot_model.hpp"

namespace robotskin::control {

struct FootContactGains {
  double stiffness = 400;  // 1/s^2, of place and orientation
  double damping = 40;     // 1/s
  // A foot turns towards where its edge presses too hard, so that both lie flat though legs and model differ.
  double flattening = 3e-4;    // rad/s for a newton metre; 0: never
  double largest_turn = 0.03;  // rad, bound of that
};

// Asks for the acceleration stiffness (X0 - X) - damping V of both feet, rows (12, n). The feet's wrenches that hold
// the robot are whatever this takes: the base has no motor, and the floor gives its torque.
class FootContactTask final : public Task {
 public:
  // Throws ControlError for gains that are not finite and not negative, ModelError for a link the robot does not have.
  FootContactTask(const RobotModel& robot, const std::vector<Foot>& feet, FootContactGains gains = {});
  void start(const TaskInput& input) noexcept override;
  [[nodiscard]] bool update(const TaskInput& input) noexcept override;

  // (2) rad about x and y of each foot, what it has turned to lie flat.
  const std::array<std::array<double, 2>, 2>& turned() const noexcept { return turned_; }

 private:
  void flatten(const TaskInput& input) noexcept;

  FootContactGains gains_;
  std::array<std::size_t, 2> link_{};
  std::array<std::array<double, 2>, 2> half_{};
  std::array<std::array<double, 16>, 2> begin_{};  // world from link
  std::array<std::array<double, 2>, 2> turned_{};
};

}  // namespace robotskin::control
