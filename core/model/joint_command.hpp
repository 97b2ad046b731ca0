// SPDX-License-Identifier: Apache-2.0
// What a robot is told to do for one cycle, through one of the three interfaces robots offer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace robotskin {

enum class CommandMode : std::uint8_t { position, velocity, torque };

// One entry a joint, in the order of RobotModel::joint_names(). Copying between commands of one robot allocates
// nothing.
struct JointCommand {
  JointCommand() = default;
  JointCommand(CommandMode command_mode, std::size_t joint_count) : mode(command_mode), value(joint_count) {}

  CommandMode mode = CommandMode::position;
  std::vector<double> value;  // (n) rad, rad/s or Nm by mode; m, m/s or N for prismatic joints

  std::size_t joint_count() const noexcept { return value.size(); }
};

}  // namespace robotskin
