// SPDX-License-Identifier: Apache-2.0
// A cell that does everything late.
#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

void draw(FaultDraw& draw, Fault& fault) {
  fault.cell = draw.cell();
  fault.by_ns = draw.time_between(FaultDraw::ms / 20, FaultDraw::ms);
  fault.lasts_ns = draw.time_between(FaultDraw::ms, 40 * FaultDraw::ms);
}

void begin(Network::RunningFault& act, int) {
  act.cell().slow_ns = act.fault.by_ns;
}

void end(Network::RunningFault& act) {
  act.cell().slow_ns = 0;
}

void tell(const Fault& fault, bool begins, FaultWitness& witness) {
  const std::int64_t for_ns = begins ? fault.lasts_ns : 0;
  witness.links_of_cell_fall(static_cast<std::size_t>(fault.cell), for_ns, begins ? 1 : 0);
  witness.disturbed(for_ns, 2 * fault.by_ns);
}

}  // namespace

constinit const FaultType slow{
    .number = 6,
    .name = "slow",
    .keys = "cell! by=200us for=20ms",
    .text = "each frame and each wake-up of the cell comes so much later",
    .draw = draw,
    .begin = begin,
    .end = end,
    .truth = {.everywhere = true},
    .tell = tell,
};

}  // namespace robotskin::world::faults
