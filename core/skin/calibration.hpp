// From counts to SI: what one count of each channel means (channels.h), and the tare of the force sensors.
#pragma once

#include "robotskin/channels.h"

namespace robotskin::skin {

inline constexpr double standard_gravity = 9.80665;  // m/s^2

// One count of each channel in the unit of channels.h.
#define ROBOTSKIN_STEP(name, is_signed, bits, numerator, denominator, unit) \
  inline constexpr double name##_step = static_cast<double>(numerator) / (denominator);
RS_CHANNELS(ROBOTSKIN_STEP)
#undef ROBOTSKIN_STEP

// The ends of each channel's range, in counts.
#define ROBOTSKIN_ENDS(name, is_signed, bits, numerator, denominator, unit)    \
  inline constexpr int name##_lowest = (is_signed) ? -(1 << ((bits) - 1)) : 0; \
  inline constexpr int name##_highest = (is_signed) ? (1 << ((bits) - 1)) - 1 : (1 << (bits)) - 1;
RS_CHANNELS(ROBOTSKIN_ENDS)
#undef ROBOTSKIN_ENDS

}  // namespace robotskin::skin
