// SPDX-License-Identifier: Apache-2.0
// When an epoch's torque sums are complete, and when they are forgotten: both ledgers go by it.
#pragma once

#include <cstdint>

#include "campaign/ground_truth.hpp"
#include "robotskin/timing.h"

namespace robotskin::campaign {

inline constexpr std::int64_t epoch_ns = std::int64_t{RS_EPOCH_TICKS} * RS_TICK_US * us;
// The numbers on the wire go round in 256 ms; what comes under one of them so late is another epoch.
inline constexpr std::int64_t forgotten_ns = 100 * ms;
// A sum is on its way for less than an epoch, and waits in a datagram for a millisecond.
inline constexpr std::int64_t complete_ns = 2 * epoch_ns;
// Children that have just changed over are not waited for in their first epoch, nor known to the section unit until
// the second is over.
inline constexpr std::int64_t at_rest_ns = 5 * epoch_ns;

// Whether the sums of a tree so deep can be in time. They go up hop by hop, each in 120 us, the processor's time and
// 50 us for each further limb, and have to be there 3.7 ms after the epoch's begin; clocks are a quarter of a
// millisecond apart.
inline bool sums_in_time(std::int32_t deepest, std::int32_t limbs, const ProcessingTimes& times) {
  const std::int64_t hop_ns = idle_hop_ns + times.sum_ns;
  return deepest * hop_ns + (limbs - 1) * RS_FRAME_US * us + RS_TORQUE_EARLY_US * us <= RS_TORQUE_END_US * us;
}

}  // namespace robotskin::campaign
