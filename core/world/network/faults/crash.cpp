// SPDX-License-Identifier: Apache-2.0
// A cell that dies.
#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

void draw(FaultDraw& draw, Fault& fault) {
  fault.cell = draw.cell();
}

void begin(Network::RunningFault& act, int) {
  if (act.cell_has_power()) act.network.kill(act.cell_index());
}

}  // namespace

constinit const FaultType crash{
    .number = 8,
    .name = "crash",
    .keys = "cell!",
    .text = "the cell falls silent for good",
    .draw = draw,
    .course = FaultCourse::momentary,
    .begin = begin,
    .truth = {.loses = FaultTruth::Loses::cell},
    .tell = tell_change,
};

}  // namespace robotskin::world::faults
