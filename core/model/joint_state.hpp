// SPDX-License-Identifier: Apache-2.0
// What is known about a robot's joints at one instant.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace robotskin {

// The stamp of something that was never measured; it is older than every real stamp.
inline constexpr std::int64_t never_ns = std::numeric_limits<std::int64_t>::min();

// Arrays have one entry a joint, in the order of RobotModel::joint_names(). Copying between states of one robot
// allocates nothing. For prismatic joints read m, m/s and N instead of rad, rad/s and Nm.
struct JointState {
  JointState() = default;
  explicit JointState(std::size_t joint_count) : position(joint_count), velocity(joint_count), effort(joint_count) {}

  std::vector<double> position;      // (n) rad
  std::vector<double> velocity;      // (n) rad/s
  std::vector<double> effort;        // (n) Nm, measured at the joint, positive along its axis
  std::int64_t stamp_ns = never_ns;  // host clock when the joints were measured

  std::size_t joint_count() const noexcept { return position.size(); }
};

}  // namespace robotskin
