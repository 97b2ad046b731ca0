// SPDX-License-Identifier: Apache-2.0
// How long the skin task takes, beside the bare product it is made of and the equations taken literally.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "baselines/naive_skin_task.hpp"
#include "control/touch_wrench.hpp"

namespace robotskin::lab {

// One entry a round, nanoseconds.
struct SkinTaskTimes {
  std::vector<std::int64_t> product;     // one 6 x n product in double precision with a number for each cell
  std::vector<std::int64_t> single;      // the same in single precision, as the task does it
  std::vector<std::int64_t> task;        // thresholds, activation, products and joint torques
  std::vector<std::int64_t> kinematics;  // what both need: the update of the dynamics
  std::vector<std::int64_t> naive;       // a Jacobian a cell; every tenth round, since it is slow
};

// Alternates between the two states, so that no round finds its results ready, and between what is measured, so that
// all meet the same machine.
SkinTaskTimes time_skin_task(const RobotModel& robot, const skin::SkinModel& skin, const control::SkinGains& gains,
                             const skin::SkinState& state, const skin::SkinState& other,
                             std::span<const double> position, std::size_t rounds);

// Nanoseconds of each update of the dynamics: the kernel beside which other times stand. Empty if the position does not
// fit the robot.
std::vector<std::int64_t> time_dynamics_update(const RobotModel& robot, std::span<const double> position,
                                               std::size_t rounds);

}  // namespace robotskin::lab
