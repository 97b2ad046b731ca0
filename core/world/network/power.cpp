// SPDX-License-Identifier: Apache-2.0
// Power: which cells are fed. A cell that is cut off, killed, started anew.
#include <algorithm>
#include <deque>
#include <vector>

#include "world/network/parts.hpp"
#include "world/random.hpp"

namespace robotskin::world {

void Network::supply(Lane& lane) {
  ++lane.topology_revision;
  std::vector<bool> fed(cells_.size());
  std::deque<std::size_t> next;
  const auto feed = [&](std::int32_t to) {
    if (to < 0 || static_cast<std::size_t>(to) >= cell_wires()) return;
    const std::size_t cell = static_cast<std::size_t>(to) / RS_PORTS;
    if (fed[cell]) return;
    fed[cell] = true;
    next.push_back(cell);
  };
  const auto conducts = [this](const Wire& wire) {
    return wire.to >= 0 && !(wire.severed != 0 && wires_[wire.to].severed != 0);
  };
  for (const std::uint32_t u : lane.units)
    for (std::size_t p = 0; p < units_[u].config.ports; ++p) {
      const Wire& wire = wires_[cell_wires() + RS_SECTION_UNIT_PORTS_MAX * u + p];
      if (((units_[u].power & ~units_[u].unfed) >> p & 1) != 0 && conducts(wire)) feed(wire.to);
    }
  while (!next.empty()) {
    const std::size_t cell = next.front();
    next.pop_front();
    for (std::size_t p = 0; p < RS_PORTS; ++p)
      if (conducts(wires_[RS_PORTS * cell + p])) feed(wires_[RS_PORTS * cell + p].to);
  }
  for (const std::uint32_t i : lane.cells) {
    Cell& cell = cells_[i];
    if (fed[i] && cell.power == Cell::Power::off) {
      cell.power = Cell::Power::starting;
      const double delay_us = options_.line.power_up_spread_us * random_unit(cell.boot_key, 1U << 20 | cell.boots);
      wake_cell(i, lane.now_ns + static_cast<std::int64_t>(1e3 * delay_us));
    } else if (!fed[i] && cell.power != Cell::Power::off && cell.power != Cell::Power::dead) {
      kill(i);
      cell.power = Cell::Power::off;
    }
  }
}

void Network::cut(std::size_t cell, int port, bool out, bool in) {
  sever(wires_.size() > RS_PORTS * cell ? RS_PORTS * cell + port - 1 : wires_.size(), severed_by_cut, out, in);
}

void Network::mend(std::size_t cell, int port) {
  cut(cell, port, false, false);
}

void Network::kill(std::size_t index) {
  Cell& cell = cells_.at(index);
  ++lane_of_cell(index).topology_revision;
  cell.power = Cell::Power::dead;
  cell.due_ns = never;
  for (std::size_t p = 0; p < RS_PORTS; ++p) wires_[RS_PORTS * index + p].end_ns = never;
  forget_board(index);
}

void Network::reboot(std::size_t index, std::int64_t off_ns) {
  kill(index);
  cells_[index].power = Cell::Power::starting;
  wake_cell(index, lane_of_cell(index).now_ns + std::max<std::int64_t>(off_ns, 1));
}

// Which ports are free is known to the link hardware, whatever the processor's memory says.
void Network::report_idle_wires(std::size_t index) {
  for (std::size_t p = 0; p < RS_PORTS; ++p) {
    if (!takes_frame(RS_PORTS * index + p)) continue;
    rs_input input{};
    input.kind = RS_INPUT_SENT;
    input.port = static_cast<std::uint8_t>(p + 1);
    step_cell(index, input);
  }
}

}  // namespace robotskin::world
