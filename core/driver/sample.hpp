// SPDX-License-Identifier: Apache-2.0
// What the driver keeps of each cell: its newest sample, in counts, and the evidence of its health.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "robotskin/wire.h"

namespace robotskin::driver {

using CellKey = std::uint32_t;  // section-unit group << 16 | id

template <bool is_signed>
using Counts = std::conditional_t<is_signed, std::int16_t, std::uint16_t>;

// With further channels, of a board that has some.
struct FurtherSample {
  std::int64_t further_ns = 0;  // host clock at the last sample of them; 0: none
};
struct NoFurtherSample {};
inline constexpr bool has_further_channels = RS_FURTHER_CHANNEL_COUNT > 0;

// One cache line, two with further channels. The counts of each sensor are an array of its name (channels.h).
struct alignas(64) Sample : std::conditional_t<has_further_channels, FurtherSample, NoFurtherSample> {
  std::int64_t stamp_ns = 0;    // host clock at the sample
  std::int64_t arrival_ns = 0;  // host clock when its frame reached the section unit
  std::int64_t moved_ns = 0;    // host clock when the acceleration last differed from the one before
  std::int64_t gone_ns = 0;  // host clock when the last neighbour stopped reporting the cell; 0: reported, or never was
  CellKey key = 0;           // 0: the row is not used yet
  std::uint32_t clock_frames = 0, event_frames = 0;
#define ROBOTSKIN_COUNTS(name, is_signed, first, channels, column, blank, unit) \
  std::array<Counts<(is_signed) != 0>, channels> name{};
  RS_SENSORS(ROBOTSKIN_COUNTS)
#undef ROBOTSKIN_COUNTS
  std::uint8_t sequence = 0;
  bool seen : 1 = false;              // a sample has come
  bool event : 1 = false;             // in event mode
  bool fault : 1 = false;             // the cell says that a sensor is missing or saturated
  bool refresh : 1 = false;           // sent for freshness
  std::uint8_t rate_divisor : 4 = 1;  // in clock mode every n-th sample is sent, by order of the section unit
};
static_assert(sizeof(Sample) == (has_further_channels ? 128 : 64));

// Host clock at the last sample of the further channels; 0: none.
template <class Row>
std::int64_t further_ns(const Row& sample) {
  if constexpr (requires { sample.further_ns; }) {
    return sample.further_ns;
  } else {
    return 0;
  }
}

// Writes the channels of a sample frame.
inline void take_channels(Sample& sample, const rs_clock& frame) {
#define ROBOTSKIN_VALUE(name, is_signed, bits, numerator, denominator, unit) static_cast<std::int32_t>(frame.name),
  const std::array<std::int32_t, RS_CHANNEL_ALL_COUNT> value{RS_CHANNELS(ROBOTSKIN_VALUE)};
#undef ROBOTSKIN_VALUE
#define ROBOTSKIN_TAKE(name, is_signed, first, channels, column, blank, unit)           \
  for (std::size_t i = 0; RS_CHANNEL_##first < RS_CHANNEL_COUNT && i < (channels); ++i) \
    sample.name[i] = static_cast<Counts<(is_signed) != 0>>(value[RS_CHANNEL_##first + i]);
  RS_SENSORS(ROBOTSKIN_TAKE)
#undef ROBOTSKIN_TAKE
}

// Writes the further channels.
inline void take_channels(Sample& sample, const rs_further& frame) {
  const std::array<std::uint32_t, RS_FURTHER_CHANNELS_MAX> value{frame.value_1, frame.value_2, frame.value_3,
                                                                 frame.value_4, frame.value_5, frame.value_6};
#define ROBOTSKIN_TAKE(name, is_signed, first, channels, column, blank, unit)            \
  for (std::size_t i = 0; RS_CHANNEL_##first >= RS_CHANNEL_COUNT && i < (channels); ++i) \
    sample.name[i] = static_cast<Counts<(is_signed) != 0>>(value[RS_CHANNEL_##first - RS_CHANNEL_COUNT + i]);
  RS_SENSORS(ROBOTSKIN_TAKE)
#undef ROBOTSKIN_TAKE
}

// How long before `arrival_ns` (section unit's clock) the sample was taken. A frame tells its sample's time only within
// 16 ticks of a millisecond; cell clocks are a little early or late, hence the guard.
template <class Frame>
std::int64_t sample_age_ns(const Frame& frame, std::uint64_t arrival_ns) {
  constexpr std::uint64_t tick_ns = 1'000'000, cycle_ns = 16 * tick_ns, guard_ns = tick_ns / 2;
  const std::uint64_t sample_ns = frame.sample_tick * tick_ns + frame.sample_phase * (tick_ns / 64);
  const std::uint64_t age_ns = (arrival_ns - sample_ns + guard_ns) % cycle_ns;
  return age_ns > guard_ns ? static_cast<std::int64_t>(age_ns - guard_ns) : 0;
}

}  // namespace robotskin::driver
