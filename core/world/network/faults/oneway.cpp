// SPDX-License-Identifier: Apache-2.0
// A wire that carries one way only.
#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

void draw(FaultDraw& draw, Fault& fault) {
  draw.place(fault);
  fault.way = draw.below(2) == 0 ? FaultWay::out : FaultWay::in;
  fault.lasts_ns = draw.while_ns(FaultDraw::ms, 60 * FaultDraw::ms);
}

void begin(Network::RunningFault& act, int) {
  act.cut(act.fault.way == FaultWay::out, act.fault.way == FaultWay::in);
}

void end(Network::RunningFault& act) {
  act.cut(false, false);
}

}  // namespace

constinit const FaultType oneway{
    .number = 2,
    .name = "oneway",
    .keys = "cell unit port! way=out for=0",
    .text = "the wire carries nothing out of that port, or nothing in",
    .either = true,
    .draw = draw,
    .begin = begin,
    .end = end,
    .truth = {.loses = FaultTruth::Loses::wire},
    .tell = tell_change,
};

}  // namespace robotskin::world::faults
