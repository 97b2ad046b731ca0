// SPDX-License-Identifier: Apache-2.0
// A cell that loses power for a moment.
#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

void draw(FaultDraw& draw, Fault& fault) {
  fault.cell = draw.cell();
  fault.lasts_ns = draw.time_between(FaultDraw::ms / 10, 10 * FaultDraw::ms);
}

void begin(Network::RunningFault& act, int) {
  if (act.cell_has_power()) act.network.reboot(act.cell_index(), act.fault.lasts_ns);
}

}  // namespace

constinit const FaultType reboot{
    .number = 9,
    .name = "reboot",
    .keys = "cell! off=2ms",
    .text = "the cell loses power so long, and starts anew",
    .draw = draw,
    .course = FaultCourse::momentary,
    .begin = begin,
    .truth = {.loses = FaultTruth::Loses::cell},
    .tell = tell_change,
};

}  // namespace robotskin::world::faults
