// SPDX-License-Identifier: Apache-2.0
// The skin task as the equations state it: a Jacobian for every cell [Cheng19 eq. 15 to 17]. The oracle of the tests
// and the yardstick of the benchmark; the cycle uses TouchWrench.
#pragma once

#include <span>
#include <vector>

#include "model/robot_dynamics.hpp"
#include "model/robot_model.hpp"
#include "skin/skin_model.hpp"

namespace robotskin::lab {

class NaiveSkinTask {
 public:
  // Throws ModelError for a link the robot does not have.
  NaiveSkinTask(const RobotModel& robot, const skin::SkinModel& skin);

  std::size_t cell_count() const noexcept { return skin_.size(); }

  // torque (n) Nm from magnitude (N) newton, what each cell asks for along its normal.
  void compute(const RobotDynamics& dynamics, std::span<const float> magnitude, std::span<double> torque);

 private:
  const skin::SkinModel skin_;
  std::vector<std::size_t> link_;  // (L) link of the robot
  std::vector<double> jacobian_;   // (6, n)
};

}  // namespace robotskin::lab
