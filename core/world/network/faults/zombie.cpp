// SPDX-License-Identifier: Apache-2.0
// A processor that hangs while its link hardware goes on.
#include "robotskin/crc.h"
#include "robotskin/timing.h"
#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

void draw(FaultDraw& draw, Fault& fault) {
  fault.cell = draw.cell();
  fault.lasts_ns = draw.while_ns(FaultDraw::ms, 60 * FaultDraw::ms);
}

void begin(Network::RunningFault& act, int) {
  if (!act.cell_is_on()) return;
  act.topology_changed();
  act.set_zombie(true);
  act.wake_cell(act.now_ns() + RS_TICK_US * 1000);
}

void end(Network::RunningFault& act) {
  if (!act.cell_is_zombie()) return;
  act.topology_changed();
  act.set_zombie(false);
  act.report_idle_wires();
}

void tell(const Fault& fault, bool begins, FaultWitness& witness) {
  witness.processor_stuck(static_cast<std::size_t>(fault.cell), begins);
}

}  // namespace

constinit const FaultType zombie{
    .number = 7,
    .name = "zombie",
    .keys = "cell! for=0",
    .text = "the cell hears nothing and repeats its last beacon every millisecond",
    .draw = draw,
    .begin = begin,
    .end = end,
    .truth = {.everywhere = true},
    .tell = tell,
};

}  // namespace robotskin::world::faults

namespace robotskin::world {

// The stuck processor's link hardware sends the beacon it was given last, again and again.
void Network::run_zombie(std::size_t index) {
  Cell& cell = cells_[index];
  const rs_route& route = cell.state.route;
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    Wire& wire = wires_[RS_PORTS * index + port];
    if (wire.end_ns != never) continue;
    rs_tick tick{};
    tick.type = RS_TYPE_tick;
    tick.hops = route.hops;
    tick.sender = cell.state.id;
    tick.sender_port = port;
    tick.nonce = cell.state.nonce;
    tick.parent = route.parent_port == port + 1U ? 1 : 0;
    tick.heard = route.neighbour[port].up ? 1 : 0;
    rs_wave_into_tick(&tick, &route.wave);
    std::uint8_t* frame = cell.state.queues.sending[port][0];
    rs_tick_pack(frame, &tick);
    rs_frame_seal(frame);
    start(static_cast<std::uint32_t>(RS_PORTS * index + port), frame, lane_of_cell(index).now_ns);
  }
  wake_cell(index, lane_of_cell(index).now_ns + RS_TICK_US * 1000);
}

}  // namespace robotskin::world
