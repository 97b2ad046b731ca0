// SPDX-License-Identifier: Apache-2.0
// Bit errors.
#include "world/network/fault_type.hpp"
#include "world/network/faults/line_trouble.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

void draw(FaultDraw& draw, Fault& fault) {
  draw_line_place(draw, fault);
  fault.lasts_ns = draw.time_between(FaultDraw::ms, 40 * FaultDraw::ms);
  fault.amount = static_cast<double>(1 + draw.below(50)) / 10000;
}

void begin(Network::RunningFault& act, int) {
  act.take_own_wires_both_ways();
  act.trouble(act.fault.amount, 0);
}

void end(Network::RunningFault& act) {
  act.trouble(-act.fault.amount, 0);
}

void tell(const Fault& fault, bool begins, FaultWitness& witness) {
  tell_line_trouble(fault, begins, 1 - std::pow(1 - fault.amount, double{RS_FRAME_BITS}), witness);
}

}  // namespace

constinit const FaultType noise{
    .number = 4,
    .name = "noise",
    .keys = "cell unit port rate=0.001 for=20ms",
    .text = "bits flip before the checksum, on one wire or on all",
    .draw = draw,
    .begin = begin,
    .end = end,
    .truth = {.everywhere = true},
    .tell = tell,
};

}  // namespace robotskin::world::faults
