// SPDX-License-Identifier: Apache-2.0
// Frames that vanish.
#include "world/network/fault_type.hpp"
#include "world/network/faults/line_trouble.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

void draw(FaultDraw& draw, Fault& fault) {
  draw_line_place(draw, fault);
  fault.lasts_ns = draw.time_between(FaultDraw::ms / 10, 6 * FaultDraw::ms);
  fault.amount = static_cast<double>(1 + draw.below(20)) / 20;
}

void begin(Network::RunningFault& act, int) {
  act.take_own_wires_both_ways();
  act.trouble(0, act.fault.amount);
}

void end(Network::RunningFault& act) {
  act.trouble(0, -act.fault.amount);
}

void tell(const Fault& fault, bool begins, FaultWitness& witness) {
  tell_line_trouble(fault, begins, fault.amount, witness);
}

}  // namespace

constinit const FaultType burst{
    .number = 5,
    .name = "burst",
    .keys = "cell unit port share=1 for=2ms",
    .text = "frames vanish, on one wire or on all",
    .draw = draw,
    .begin = begin,
    .end = end,
    .truth = {.loses = FaultTruth::Loses::wire, .everywhere = true},
    .tell = tell,
};

}  // namespace robotskin::world::faults
