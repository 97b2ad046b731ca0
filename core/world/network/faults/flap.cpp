// SPDX-License-Identifier: Apache-2.0
// A loose contact.
#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

void draw(FaultDraw& draw, Fault& fault) {
  draw.place(fault);
  fault.count = 1 + static_cast<std::int32_t>(draw.below(8));
  fault.by_ns = draw.time_between(FaultDraw::ms / 2, 16 * FaultDraw::ms);
}

void begin(Network::RunningFault& act, int) {
  act.cut(true, true);
}

void end(Network::RunningFault& act) {
  act.cut(false, false);
}

}  // namespace

constinit const FaultType flap{
    .number = 3,
    .name = "flap",
    .keys = "cell unit port! times=5 period=2ms",
    .text = "the wire is cut and mended, times over, half a period each",
    .either = true,
    .draw = draw,
    .course = FaultCourse::alternating,
    .begin = begin,
    .end = end,
    .tell = tell_change,
};

}  // namespace robotskin::world::faults
