// SPDX-License-Identifier: Apache-2.0
// From counts to SI: what one count of each channel means (channels.h), and the tare of the force sensors.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>

#include "robotskin/channels.h"

namespace robotskin::skin {

inline constexpr double standard_gravity = 9.80665;  // m/s^2

// One count of each channel in the unit of channels.h.
#define ROBOTSKIN_STEP(name, is_signed, bits, numerator, denominator, unit) \
  inline constexpr double name##_step = static_cast<double>(numerator) / (denominator);
RS_ALL_CHANNELS(ROBOTSKIN_STEP)
#undef ROBOTSKIN_STEP

struct ChannelScale {
  std::int32_t lowest, highest;  // counts
  float si_step;                 // one count in SI
};

// By rs_channel.
#define ROBOTSKIN_SCALE(name, is_signed, bits, numerator, denominator, unit)                                      \
  ChannelScale{(is_signed) ? -(1 << ((bits) - 1)) : 0, (is_signed) ? (1 << ((bits) - 1)) - 1 : (1 << (bits)) - 1, \
               static_cast<float>(name##_step * (std::string_view(unit) == "g" ? standard_gravity : 1.0))},
inline constexpr std::array<ChannelScale, RS_CHANNEL_ALL_COUNT> channel_scales{{RS_ALL_CHANNELS(ROBOTSKIN_SCALE)}};
#undef ROBOTSKIN_SCALE

// Of one sensor, whose first channel is `first`, from counts.
template <class AllCounts, class Values>
void to_si(const AllCounts& counts, std::size_t first, Values& values) {
  if constexpr (std::is_same_v<Values, float>) {
    values = counts[0] * channel_scales[first].si_step;
  } else {
    for (std::size_t i = 0; i < counts.size(); ++i) values[i] = counts[i] * channel_scales[first + i].si_step;
  }
}

}  // namespace robotskin::skin
