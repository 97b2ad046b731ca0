// SPDX-License-Identifier: Apache-2.0
// Datagrams that take longer.
#include "world/network/fault_type.hpp"
#include "world/network/faults/ethernet_trouble.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

void draw(FaultDraw& draw, Fault& fault) {
  fault.unit = draw.unit();
  fault.by_ns = draw.time_between(FaultDraw::ms / 10, 40 * FaultDraw::ms);
  draw_ethernet_end(draw, fault);
}

void passage(const Fault& fault, FaultyPassage& passage) {
  if (is_on_the_way(fault, passage)) passage.delay_ns += fault.by_ns;
}

}  // namespace

constinit const FaultType delay{
    .number = 21,
    .name = "delay",
    .keys = "unit! to by! for=0",
    .text = "datagrams from the unit to another, or to all, take so much longer",
    .to = FaultTo::unit,
    .draw = draw,
    .can_be_drawn = has_two_units,
    .begin = begin_ethernet_trouble,
    .end = end_ethernet_trouble,
    .passage = passage,
};

}  // namespace robotskin::world::faults
