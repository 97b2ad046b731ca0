// SPDX-License-Identifier: Apache-2.0
// A section unit alone.
#include "world/network/fault_type.hpp"
#include "world/network/faults/ethernet_trouble.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

void draw(FaultDraw& draw, Fault& fault) {
  fault.unit = draw.unit();
  draw_ethernet_end(draw, fault);
}

void passage(const Fault& fault, FaultyPassage& passage) {
  const auto unit = static_cast<std::size_t>(fault.unit);
  passage.lost = passage.lost || passage.from == unit || passage.to == unit;
}

}  // namespace

constinit const FaultType partition{
    .number = 23,
    .name = "partition",
    .keys = "unit! for=0",
    .text = "no datagram between this unit and the others arrives",
    .to = FaultTo::unit,
    .draw = draw,
    .can_be_drawn = has_two_units,
    .begin = begin_ethernet_trouble,
    .end = end_ethernet_trouble,
    .passage = passage,
};

}  // namespace robotskin::world::faults
