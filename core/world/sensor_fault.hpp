// SPDX-License-Identifier: Apache-2.0
// What may go wrong with the sensors of one simulated cell, from a time on.
#pragma once

#include <cstdint>

#include "model/spatial.hpp"
#include "robotskin/channels.h"

namespace robotskin::world {

// Rows: name, unit of its size, what it does.
#define ROBOTSKIN_SENSOR_FAULTS(ROW)                                          \
  ROW(none, "", "nothing")                                                    \
  ROW(stuck, "", "the channels stay where they are")                          \
  ROW(noisy, "1", "their noise is so many times as large")                    \
  ROW(drifting, "unit/min", "their zero moves on and on")                     \
  ROW(offset, "unit", "their zero has moved")                                 \
  ROW(mis_scaled, "1", "they show so many times what they should")            \
  ROW(loose, "", "the cell has turned, and its accelerometer with it")        \
  ROW(overheated, "K", "the cell grows so much hotter, within half a minute") \
  ROW(end_of_range, "", "they show the end of their range: the upper one, or the lower one for a size below 0")

enum class SensorFaultKind : std::uint8_t {
#define ROW(name, unit, meaning) name,
  ROBOTSKIN_SENSOR_FAULTS(ROW)
#undef ROW
};

struct SensorFault {
  SensorFaultKind kind = SensorFaultKind::none;
  std::uint32_t channels = 0;  // a bit a channel of rs_channel
  double size = 0;             // newton, g, share of full scale or K, as of the table
  double begin_s = 0;
  Matrix3 turn{1, 0, 0, 0, 1, 0, 0, 0, 1};  // loose: from the cell's frame now to the one it had

  bool of(int channel) const { return (channels >> channel & 1U) != 0; }
  bool acts(SensorFaultKind one, double time_s) const { return kind == one && time_s >= begin_s; }
};

inline constexpr double overheating_lag_s = 10;

}  // namespace robotskin::world
