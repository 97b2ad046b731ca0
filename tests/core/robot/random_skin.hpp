// SPDX-License-Identifier: Apache-2.0
// Cells anywhere on any link of a robot, for programs that only need many of them.
#pragma once

#include <cstdint>
#include <random>

#include "model/robot_model.hpp"
#include "skin/skin_model.hpp"

namespace robotskin {

constexpr std::size_t cells = 260;

inline skin::SkinModel random_skin(const RobotModel& robot, std::mt19937_64& generator) {
  std::uniform_real_distribution<double> place(-0.1, 0.1);
  skin::SkinModel skin;
  skin.link_names.assign(robot.link_names().begin(), robot.link_names().end());
  for (std::size_t cell = 0; cell < cells; ++cell) {
    skin.key.push_back(static_cast<skin::CellKey>(cell + 1));
    skin.link.push_back(static_cast<std::int32_t>(generator() % robot.link_count()));
    skin.link_from_cell_rotation.push_back({1, 0, 0, 0, 0, -1, 0, 1, 0});
    skin.link_from_cell_translation.push_back({place(generator), place(generator), place(generator)});
    skin.neighbours.emplace_back();
    skin.patch.push_back(static_cast<std::int32_t>(cell % 3));
  }
  return skin;
}

}  // namespace robotskin
