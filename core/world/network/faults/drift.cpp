// SPDX-License-Identifier: Apache-2.0
// A clock that goes wrong.
#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

// A cell's clock shows the same now, and goes on faster or slower. An end takes back all of it.
void set_drift(Network::RunningFault& act, double ppm) {
  if (act.fault.cell < 0) {
    act.unit().set_drift(act.now_ns(), 1e-6 * ppm);
    act.wake_unit();
    return;
  }
  auto& cell = act.cell();
  const std::uint32_t shown_us = cell.clock_us(act.now_ns());
  const double rate = 1 + 1e-6 * ppm;
  cell.us_per_ns = 1e-3 * rate;
  cell.ns_per_us = 1e3 / rate;
  cell.clock_start_us += shown_us - cell.clock_us(act.now_ns());
}

void draw(FaultDraw& draw, Fault& fault) {
  if (draw.units() > 0 && draw.below(2) == 0)
    fault.unit = draw.unit();
  else
    fault.cell = draw.cell();
  // Cells' oscillators are bad, section units have crystals.
  fault.amount = (fault.unit < 0 ? 100.0 : 1.0) * (static_cast<double>(draw.below(401)) - 200);
}

void begin(Network::RunningFault& act, int) {
  set_drift(act, act.fault.amount);
}

void end(Network::RunningFault& act) {
  set_drift(act, 0);
}

}  // namespace

constinit const FaultType drift{
    .number = 17,
    .name = "drift",
    .keys = "cell unit ppm! for=0",
    .text = "a clock goes so much faster or slower",
    .either = true,
    .draw = draw,
    .begin = begin,
    .end = end,
};

}  // namespace robotskin::world::faults
