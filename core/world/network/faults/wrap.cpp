// SPDX-License-Identifier: Apache-2.0
// A tick number that begins again.
#include <algorithm>

#include "robotskin/timing.h"
#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

void draw(FaultDraw&, Fault&) {}

// A run has one.
bool can_be_drawn(const Wiring&, std::span<const Fault> so_far) {
  return std::ranges::none_of(so_far, [](const Fault& fault) { return type_of(fault).number == wrap.number; });
}

void at_start(const Fault& fault, NetworkOptions& options) {
  constexpr std::int64_t turn_ns = 65536LL * RS_TICK_US * 1000;
  options.epoch_ns += turn_ns - (options.epoch_ns + fault.time_ns) % turn_ns;
}

}  // namespace

constinit const FaultType wrap{
    .number = 24,
    .name = "wrap",
    .keys = "",
    .text = "the 16-bit tick number wraps at that time: the clocks are set so at the start",
    .draw = draw,
    .can_be_drawn = can_be_drawn,
    .course = FaultCourse::momentary,
    .at_start = at_start,
};

}  // namespace robotskin::world::faults
