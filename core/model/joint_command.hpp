// SPDX-License-Identifier: Apache-2.0
// What a robot is told to do for one cycle, through one of the three interfaces robots offer.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace robotskin {

enum class CommandMode : std::uint8_t { position, velocity, torque };

// One entry a joint, in the order of RobotModel::joint_names(). Copying between commands of one robot allocates
// nothing.
struct JointCommand {
  JointCommand() = default;
  JointCommand(CommandMode of_all, std::size_t joint_count) : mode(joint_count, of_all), value(joint_count) {}

  std::vector<CommandMode> mode;  // (n) a hand may take torques on an arm that takes velocities
  std::vector<double> value;      // (n) rad, rad/s or Nm by mode; m, m/s or N for prismatic joints

  std::size_t joint_count() const noexcept { return value.size(); }
  // The mode of all joints; none if they differ.
  std::optional<CommandMode> common_mode() const noexcept {
    if (mode.empty() || std::ranges::any_of(mode, [&](CommandMode one) { return one != mode.front(); })) return {};
    return mode.front();
  }
};

}  // namespace robotskin
