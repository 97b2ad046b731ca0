// SPDX-License-Identifier: Apache-2.0
// A section unit that hangs.
#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

void draw(FaultDraw& draw, Fault& fault) {
  fault.unit = draw.unit();
  fault.lasts_ns = draw.while_ns(FaultDraw::ms, 60 * FaultDraw::ms);
}

void begin(Network::RunningFault& act, int) {
  act.topology_changed();
  act.unit().stopped = true;
  for (std::size_t p = 0; p < RS_SECTION_UNIT_PORTS_MAX; ++p)
    act.wire(act.cell_wires() + RS_SECTION_UNIT_PORTS_MAX * static_cast<std::size_t>(act.fault.unit) + p).end_ns =
        never;
}

void end(Network::RunningFault& act) {
  if (!act.unit().stopped) return;
  act.topology_changed();
  act.boot_unit();
}

}  // namespace

constinit const FaultType stop{
    .number = 19,
    .name = "stop",
    .keys = "unit! for=0",
    .text = "a section unit's processor stops, and starts anew; its ports keep their power",
    .draw = draw,
    .can_be_drawn = has_units,
    .begin = begin,
    .end = end,
    .tell = tell_change,
};

}  // namespace robotskin::world::faults
