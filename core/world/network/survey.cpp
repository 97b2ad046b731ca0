// SPDX-License-Identifier: Apache-2.0
// What is so in the network: states, depths, and whether it has formed.
#include <vector>

#include "world/network/parts.hpp"
#include "world/network/path_survey.hpp"

namespace robotskin::world {

std::size_t Network::cell_count() const {
  return cells_.size();
}

std::size_t Network::unit_count() const {
  return units_.size();
}

const rs_cell& Network::cell(std::size_t index) const {
  return cells_.at(index).state;
}

bool Network::alive(std::size_t cell) const {
  return cells_.at(cell).power == Cell::Power::on;
}

bool Network::starting(std::size_t cell) const {
  return cells_.at(cell).power == Cell::Power::starting;
}

bool Network::unit_runs(std::size_t unit) const {
  return !units_.at(unit).stopped;
}

bool Network::port_powered(std::size_t unit, int port) const {
  return (units_.at(unit).power >> (port - 1) & 1) != 0;
}

std::int64_t Network::booted_ns(std::size_t cell) const {
  return cells_.at(cell).booted_ns;
}

const rs_section_unit& Network::unit(std::size_t index) const {
  return *units_.at(index).state;
}

std::uint64_t Network::frames_dropped() const {
  std::uint64_t sum = 0;
  for (const Cell& cell : cells_) sum += cell.state.counts.frames_dropped;
  for (const Unit& unit : units_) sum += unit.state->dropped;
  return sum;
}

std::vector<std::uint32_t> Network::queue_peaks() const {
  std::vector<std::uint32_t> peaks;
  for (const Cell& cell : cells_) peaks.push_back(cell.queue_peak);
  return peaks;
}

std::vector<std::int32_t> Network::depths() const {
  PathSurvey survey(*this);
  survey.update();
  return survey.depth();
}

bool Network::formed() const {
  const std::vector<std::int32_t> depth = depths();
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const Cell& cell = cells_[i];
    if (cell.power == Cell::Power::starting) return false;
    if (depth[i] < 0) continue;
    if (cell.state.route.parent_port == RS_NO_PARENT || cell.state.route.hops != depth[i]) return false;
    if (cell.state.id == RS_ID_NONE) return false;
  }
  return true;
}

}  // namespace robotskin::world
