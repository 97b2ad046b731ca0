// Power and faults: who is fed, what is cut, killed and started again.
#include <deque>
#include <vector>

#include "world/network/parts.hpp"
#include "world/random.hpp"

namespace robotskin::world {

void Network::supply() {
  std::vector<bool> fed(cells_.size());
  std::deque<std::size_t> next;
  const auto feed = [&](std::int32_t to) {
    if (to < 0 || static_cast<std::size_t>(to) >= RS_PORTS * cells_.size()) return;
    const std::size_t cell = static_cast<std::size_t>(to) / RS_PORTS;
    if (fed[cell]) return;
    fed[cell] = true;
    next.push_back(cell);
  };
  const auto carries = [this](const Wire& wire) { return wire.to >= 0 && !(wire.cut && wires_[wire.to].cut); };
  for (std::size_t u = 0; u < units_.size(); ++u)
    for (std::size_t p = 0; p < units_[u].config.ports; ++p) {
      const Wire& wire = wires_[RS_PORTS * cells_.size() + RS_SECTION_UNIT_PORTS_MAX * u + p];
      if ((units_[u].power >> p & 1) != 0 && carries(wire)) feed(wire.to);
    }
  while (!next.empty()) {
    const std::size_t cell = next.front();
    next.pop_front();
    for (std::size_t p = 0; p < RS_PORTS; ++p)
      if (carries(wires_[RS_PORTS * cell + p])) feed(wires_[RS_PORTS * cell + p].to);
  }
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    Cell& cell = cells_[i];
    if (fed[i] && cell.power == Cell::Power::off) {
      cell.power = Cell::Power::starting;
      const double delay_us = options_.line.power_up_spread_us * random_unit(cell.boot_key, 1U << 20 | cell.boots);
      wake_cell(i, now_ns_ + static_cast<std::int64_t>(1e3 * delay_us));
    } else if (!fed[i] && (cell.power == Cell::Power::on || cell.power == Cell::Power::starting)) {
      kill(i);
      cell.power = Cell::Power::off;
    }
  }
}

void Network::cut(std::size_t cell, int port, bool out, bool in) {
  Wire& wire = wires_.at(RS_PORTS * cell + port - 1);
  if (wire.to < 0) return;
  wire.cut = wire.cut || out;
  wires_[wire.to].cut = wires_[wire.to].cut || in;
  supply();
}

void Network::mend(std::size_t cell, int port) {
  Wire& wire = wires_.at(RS_PORTS * cell + port - 1);
  if (wire.to < 0) return;
  wire.cut = wires_[wire.to].cut = false;
  supply();
}

void Network::kill(std::size_t index) {
  Cell& cell = cells_.at(index);
  cell.power = Cell::Power::dead;
  cell.due_ns = never;
  for (std::size_t p = 0; p < RS_PORTS; ++p) wires_[RS_PORTS * index + p].end_ns = never;
}

void Network::reboot(std::size_t index, std::int64_t off_ns) {
  kill(index);
  cells_[index].power = Cell::Power::starting;
  wake_cell(index, now_ns_ + std::max<std::int64_t>(off_ns, 1));
}

}  // namespace robotskin::world
