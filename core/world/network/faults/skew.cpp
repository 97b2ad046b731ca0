// SPDX-License-Identifier: Apache-2.0
// A clock that jumps.
#include <cstdlib>

#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

void draw(FaultDraw& draw, Fault& fault) {
  fault.unit = draw.unit();
  fault.by_ns = draw.time_between(0, 6 * FaultDraw::ms) - 3 * FaultDraw::ms;
}

void begin(Network::RunningFault& act, int) {
  act.unit().ahead_ns += act.fault.by_ns;
  act.wake_unit();
}

// A clock that goes back holds the ticks back for as long.
void tell(const Fault& fault, bool, FaultWitness& witness) {
  if (fault.by_ns < 0) witness.silent(fault, -fault.by_ns);
  witness.disturbed(std::abs(fault.by_ns));
}

}  // namespace

constinit const FaultType skew{
    .number = 18,
    .name = "skew",
    .keys = "unit! by!",
    .text = "a section unit's clock jumps",
    .may_go_back = true,
    .draw = draw,
    .can_be_drawn = has_units,
    .course = FaultCourse::momentary,
    .begin = begin,
    .truth = {.everywhere = true},
    .tell = tell,
};

}  // namespace robotskin::world::faults
