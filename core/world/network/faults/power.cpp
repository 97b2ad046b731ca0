// SPDX-License-Identifier: Apache-2.0
// A port without power.
#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

void draw(FaultDraw& draw, Fault& fault) {
  fault.unit = draw.unit();
  fault.port = draw.unit_port(fault.unit);
  fault.lasts_ns = draw.while_ns(FaultDraw::ms, 60 * FaultDraw::ms);
}

void begin(Network::RunningFault& act, int) {
  act.unit().unfed |= static_cast<std::uint16_t>(1U << (act.fault.port - 1));
  act.supply();
}

void end(Network::RunningFault& act) {
  act.unit().unfed &= static_cast<std::uint16_t>(~(1U << (act.fault.port - 1)));
  act.supply();
}

}  // namespace

constinit const FaultType power{
    .number = 20,
    .name = "power",
    .keys = "unit! port! for=0",
    .text = "a port feeds no power",
    .draw = draw,
    .can_be_drawn = has_units,
    .begin = begin,
    .end = end,
    .tell = tell_change,
};

}  // namespace robotskin::world::faults
