// SPDX-License-Identifier: Apache-2.0
// A plug that is moved.
#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

void draw(FaultDraw& draw, Fault& fault) {
  fault.cell = draw.cell();
  fault.port = draw.port(fault.cell);
  fault.to = draw.cell();
  fault.to_port = draw.port(fault.to);
  fault.lasts_ns = draw.while_ns(FaultDraw::ms, 60 * FaultDraw::ms);
}

void begin(Network::RunningFault& act, int) {
  const std::size_t wire = act.wire_at(act.fault.cell, act.fault.port);
  act.wires = {wire};
  if (act.wire(wire).to >= 0) act.wires.push_back(static_cast<std::size_t>(act.wire(wire).to));
  act.part(wire);
  if (act.fault.to >= 0) {
    const std::size_t to = act.wire_at(act.fault.to, act.fault.to_port);
    act.part(to);
    if (to != wire) act.join(wire, to);
  }
  act.supply();
}

void end(Network::RunningFault& act) {
  act.part(act.wires.front());
  if (act.wires.size() == 2) {
    act.part(act.wires.back());
    act.join(act.wires.front(), act.wires.back());
  }
  act.supply();
}

}  // namespace

constinit const FaultType plug{
    .number = 13,
    .name = "plug",
    .keys = "cell! port! to! to_port=1 for=0",
    .text = "the plug at the port is moved to another cell's port; to=-1: to none",
    .to = FaultTo::cell_or_none,
    .draw = draw,
    .begin = begin,
    .end = end,
    .tell = tell_change,
};

}  // namespace robotskin::world::faults
