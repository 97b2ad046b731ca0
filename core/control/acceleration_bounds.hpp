// SPDX-License-Identifier: Apache-2.0
// The accelerations that a joint may take: no faster than its velocity limit, nor than it can brake before an end.
#pragma once

#include <algorithm>
#include <cmath>

namespace robotskin::control {

// In which a velocity that a torque leads to is judged: shorter, and a joint overshoots its limit before it is held.
inline constexpr double speed_horizon_s = 0.02;

// Of one joint; for prismatic joints read m.
struct JointRoom {
  double lower, upper;  // rad
  double velocity;      // rad/s, the limit
  double braking;       // rad/s^2 on which stopping before a position limit counts
  double margin;        // rad kept from the position limits
  double horizon_s;     // in which a velocity beyond its bound is to come back
};

// What is kept of a wanted margin where the limits lie close together, as those of a gripper's jaws: 5 % of the room.
inline double kept_margin(double wanted, double lower, double upper) noexcept {
  return std::min(wanted, 0.05 * std::max(upper - lower, 0.0));
}

struct AccelerationBounds {
  double low, high;  // rad/s^2
};

inline AccelerationBounds acceleration_bounds(const JointRoom& room, double position, double velocity) noexcept {
  const double margin = kept_margin(room.margin, room.lower, room.upper);
  const double up = std::max(room.upper - margin - position, 0.0);
  const double down = std::max(position - room.lower - margin, 0.0);
  const double fastest_up = std::min(room.velocity, std::sqrt(2 * room.braking * up));
  const double fastest_down = std::min(room.velocity, std::sqrt(2 * room.braking * down));
  return {(-fastest_down - velocity) / room.horizon_s, (fastest_up - velocity) / room.horizon_s};
}

}  // namespace robotskin::control
