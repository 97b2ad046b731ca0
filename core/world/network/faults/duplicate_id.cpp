// SPDX-License-Identifier: Apache-2.0
// Two cells of one id.
#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

void draw(FaultDraw& draw, Fault& fault) {
  fault.cell = draw.cell();
  do fault.to = draw.cell();
  while (fault.to == fault.cell);
  fault.lasts_ns = draw.time_between(FaultDraw::ms / 10, 10 * FaultDraw::ms);
}

void begin(Network::RunningFault& act, int) {
  rs_settings settings;
  rs_settings_load(&settings, act.cell().flash);
  settings.id = act.cell_at(act.fault.to).state.id;
  rs_settings_store(&settings, act.cell().flash);
  if (act.cell_has_power()) act.network.reboot(act.cell_index(), act.fault.lasts_ns);
}

}  // namespace

constinit const FaultType duplicate_id{
    .number = 12,
    .name = "duplicate_id",
    .keys = "cell! to! off=1ms",
    .text = "the cell finds the id of cell `to` in its flash and starts anew",
    .to = FaultTo::cell,
    .draw = draw,
    .can_be_drawn = has_two_cells,
    .course = FaultCourse::momentary,
    .begin = begin,
    .tell = tell_change,
};

}  // namespace robotskin::world::faults
