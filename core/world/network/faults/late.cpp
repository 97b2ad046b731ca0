// SPDX-License-Identifier: Apache-2.0
// A patch that is clipped on later.
#include <algorithm>

#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

// The wires between a connected group of cells, the nearest to `cell`, and the rest.
std::vector<std::size_t> wires_around(Network::RunningFault& act, std::size_t cell, std::size_t size) {
  const std::size_t cells = act.network.cell_count();
  std::vector<std::size_t> group{cell};
  std::vector<bool> inside(cells);
  inside[cell] = true;
  const auto neighbour = [&act, cells](std::size_t of, std::size_t p) {
    const std::int32_t to = act.wire(RS_PORTS * of + p).to;
    return to < 0 || static_cast<std::size_t>(to) >= act.cell_wires() ? cells : static_cast<std::size_t>(to) / RS_PORTS;
  };
  for (std::size_t i = 0; i < group.size(); ++i)
    for (std::size_t p = 0; p < RS_PORTS && group.size() < size; ++p) {
      const std::size_t next = neighbour(group[i], p);
      if (next == cells || inside[next]) continue;
      inside[next] = true;
      group.push_back(next);
    }
  std::vector<std::size_t> wires;
  for (const std::size_t i : group)
    for (std::size_t p = 0; p < RS_PORTS; ++p) {
      const std::size_t next = neighbour(i, p);
      if (act.wire(RS_PORTS * i + p).to >= 0 && (next == cells || !inside[next])) wires.push_back(RS_PORTS * i + p);
    }
  return wires;
}

void draw(FaultDraw& draw, Fault& fault) {
  fault.cell = draw.cell();
  fault.count = 1 + static_cast<std::int32_t>(draw.below(static_cast<std::uint64_t>(std::max(draw.cells() / 4, 1))));
}

void await(Network::RunningFault& act) {
  act.wires = wires_around(act, act.cell_index(), static_cast<std::size_t>(act.fault.count));
  act.sever(act.wires, severed_as_late, true, true);
}

void begin(Network::RunningFault& act, int) {
  act.sever(act.wires, severed_as_late, false, false);
}

}  // namespace

constinit const FaultType late{
    .number = 16,
    .name = "late",
    .keys = "cell! size=1",
    .text = "the cell and its nearest, `size` in all, are clipped on only at that time",
    .draw = draw,
    .course = FaultCourse::momentary,
    .await = await,
    .begin = begin,
    .tell = tell_change,
};

}  // namespace robotskin::world::faults
