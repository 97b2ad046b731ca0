// SPDX-License-Identifier: Apache-2.0
// A wire that carries nothing any more.
#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

void draw(FaultDraw& draw, Fault& fault) {
  draw.place(fault);
  fault.lasts_ns = draw.while_ns(FaultDraw::ms, 60 * FaultDraw::ms);
}

void begin(Network::RunningFault& act, int) {
  act.cut(true, true);
}

void end(Network::RunningFault& act) {
  act.cut(false, false);
}

}  // namespace

constinit const FaultType cut{
    .number = 0,
    .name = "cut",
    .keys = "cell unit port! for=0",
    .text = "the wire at a port of a cell or section unit carries nothing",
    .either = true,
    .draw = draw,
    .begin = begin,
    .end = end,
    .truth = {.loses = FaultTruth::Loses::wire},
    .tell = tell_change,
};

}  // namespace robotskin::world::faults
