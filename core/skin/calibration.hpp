// SPDX-License-Identifier: Apache-2.0
// From counts to SI: what one count of each channel means (channels.h), and what the force sensors of a cell really
// felt.
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

// What the three force sensors of one cell felt, from what they show in newton: force_from_reading (reading - offset).
struct ForceCalibration {
  std::array<float, 3> offset{};
  std::array<float, 9> force_from_reading{1, 0, 0, 0, 1, 0, 0, 0, 1};  // row-major

  // A sensor that shows nothing counts as one that feels nothing: below its zero it cannot tell.
  std::array<float, 3> force(const std::array<float, 3>& reading) const {
    std::array<float, 3> above{}, felt{};
    for (std::size_t i = 0; i < 3; ++i) above[i] = reading[i] > 0 ? reading[i] - offset[i] : 0;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) felt[i] += force_from_reading[3 * i + j] * above[j];
    }
    return felt;
  }
};

}  // namespace robotskin::skin
