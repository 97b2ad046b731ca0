// SPDX-License-Identifier: Apache-2.0
// From counts to SI: what one count of each channel means (channels.h), and the tare of the force sensors.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "robotskin/channels.h"

namespace robotskin::skin {

inline constexpr double standard_gravity = 9.80665;  // m/s^2

// One count of each channel in the unit of channels.h.
#define ROBOTSKIN_STEP(name, is_signed, bits, numerator, denominator, unit) \
  inline constexpr double name##_step = static_cast<double>(numerator) / (denominator);
RS_CHANNELS(ROBOTSKIN_STEP)
#undef ROBOTSKIN_STEP

struct ChannelScale {
  std::int32_t lowest, highest;  // counts
  float si_step;                 // one count in SI
};

// By rs_channel.
#define ROBOTSKIN_SCALE(name, is_signed, bits, numerator, denominator, unit)                                      \
  ChannelScale{(is_signed) ? -(1 << ((bits) - 1)) : 0, (is_signed) ? (1 << ((bits) - 1)) - 1 : (1 << (bits)) - 1, \
               static_cast<float>(name##_step * (std::string_view(unit) == "g" ? standard_gravity : 1.0))},
inline constexpr std::array<ChannelScale, RS_CHANNEL_COUNT> channel_scales{{RS_CHANNELS(ROBOTSKIN_SCALE)}};
#undef ROBOTSKIN_SCALE

}  // namespace robotskin::skin
