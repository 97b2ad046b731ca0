// SPDX-License-Identifier: Apache-2.0
// Datagrams that get lost.
#include "world/network/fault_type.hpp"
#include "world/network/faults/ethernet_trouble.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

void draw(FaultDraw& draw, Fault& fault) {
  fault.unit = draw.unit();
  fault.amount = static_cast<double>(1 + draw.below(20)) / 20;
  draw_ethernet_end(draw, fault);
}

void passage(const Fault& fault, FaultyPassage& passage) {
  if (is_on_the_way(fault, passage)) passage.lost = passage.lost || passage.chance < fault.amount;
}

}  // namespace

constinit const FaultType loss{
    .number = 22,
    .name = "loss",
    .keys = "unit! to share! for=0",
    .text = "such datagrams get lost",
    .to = FaultTo::unit,
    .draw = draw,
    .can_be_drawn = has_two_units,
    .begin = begin_ethernet_trouble,
    .end = end_ethernet_trouble,
    .passage = passage,
};

}  // namespace robotskin::world::faults
