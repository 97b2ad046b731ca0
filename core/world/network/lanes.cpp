// SPDX-License-Identifier: Apache-2.0
// Lanes: what shares neither wires nor peer datagrams, run by itself, and side by side on several threads.
//
// Within a run no lane reads what another one writes. What they have in common waits until all have come as far:
// faults, which may strike anywhere, and datagrams to the host, which are handed over in the order of their times.
#include <algorithm>
#include <numeric>

#include "world/network/parts.hpp"

namespace robotskin::world {

NetworkCounts& NetworkCounts::operator+=(const NetworkCounts& other) {
  frames_sent += other.frames_sent;
  frames_delivered += other.frames_delivered;
  frames_lost += other.frames_lost;
  frames_damaged += other.frames_damaged;
  frames_overrun += other.frames_overrun;
  cell_steps += other.cell_steps;
  events += other.events;
  datagrams += other.datagrams;
  datagram_bytes += other.datagram_bytes;
  records += other.records;
  return *this;
}

// ---- Which there are ----

// Section units of a group speak to each other; wires join cells with cells and with section units.
void Network::find_lanes() {
  const std::size_t cells = cells_.size();
  std::vector<std::size_t> leader(cells + units_.size());
  std::iota(leader.begin(), leader.end(), std::size_t{0});
  const auto leader_of = [&](std::size_t at) {
    while (leader[at] != at) at = leader[at] = leader[leader[at]];
    return at;
  };
  const auto together = [&](std::size_t a, std::size_t b) { leader[leader_of(a)] = leader_of(b); };
  const auto owner = [&](std::size_t wire) {
    return wire < cell_wires() ? wire / RS_PORTS : cells + (wire - cell_wires()) / RS_SECTION_UNIT_PORTS_MAX;
  };
  for (std::size_t wire = 0; wire < wires_.size(); ++wire)
    if (wires_[wire].to >= 0) together(owner(wire), owner(static_cast<std::size_t>(wires_[wire].to)));
  for (std::size_t u = 0; u < units_.size(); ++u)
    for (std::size_t v = 0; v < u; ++v)
      if (wiring_.units[u].group == wiring_.units[v].group) together(cells + u, cells + v);

  // Each lane has section units: cells without any, and without power, go with the first.
  std::vector<std::size_t> leaders;
  for (std::size_t u = 0; u < units_.size() && options_.threads > 0; ++u)
    if (std::ranges::find(leaders, leader_of(cells + u)) == leaders.end()) leaders.push_back(leader_of(cells + u));
  lanes_.resize(std::clamp<std::size_t>(leaders.size(), 1, UINT8_MAX));
  const auto lane_of = [&](std::size_t at) {
    const auto found = std::ranges::find(leaders, leader_of(at)) - leaders.begin();
    return static_cast<std::uint8_t>(static_cast<std::size_t>(found) < lanes_.size() ? found : 0);
  };
  for (std::size_t i = 0; i < cells; ++i) lane_of_cell_.push_back(lane_of(i));
  for (std::size_t u = 0; u < units_.size(); ++u) lane_of_unit_.push_back(lane_of(cells + u));
  for (std::size_t i = 0; i < cells; ++i) lane_of_cell(i).cells.push_back(static_cast<std::uint32_t>(i));
  for (std::size_t u = 0; u < units_.size(); ++u) lane_of_unit(u).units.push_back(static_cast<std::uint32_t>(u));
  for (std::size_t n = 0; n < lanes_.size(); ++n) {
    lanes_[n].number = n;
    lanes_[n].queue.reserve(4 * RS_PORTS * lanes_[n].cells.size() + 64 * (lanes_[n].units.size() + 1));
  }
  const std::size_t threads = std::min(options_.threads, lanes_.size());
  if (threads <= 1) return;
  // The largest first, so that no thread begins a large one when the others are nearly through.
  std::vector<std::size_t> by_size(lanes_.size());
  std::iota(by_size.begin(), by_size.end(), std::size_t{0});
  std::ranges::stable_sort(by_size, std::greater<>(), [&](std::size_t lane) { return lanes_[lane].cells.size(); });
  workers_ = std::make_unique<Workers>(
      threads, lanes_.size(), [this, by_size](std::size_t piece) { run(lanes_[by_size[piece]], lanes_end_ns_); });
}

// A wire joins two lanes, between two runs: from now on they are one.
void Network::unite(std::size_t kept, std::size_t given_up) {
  Lane &to = lanes_[kept], &from = lanes_[given_up];
  for (const std::uint32_t cell : from.cells) lane_of_cell_[cell] = static_cast<std::uint8_t>(kept);
  for (const std::uint32_t unit : from.units) lane_of_unit_[unit] = static_cast<std::uint8_t>(kept);
  const auto move_indices = [](std::vector<std::uint32_t>& into, std::vector<std::uint32_t>& out_of) {
    const auto middle = into.insert(into.end(), out_of.begin(), out_of.end());
    std::inplace_merge(into.begin(), middle, into.end());
    out_of.clear();
  };
  move_indices(to.cells, from.cells);
  move_indices(to.units, from.units);
  const auto first_letter = static_cast<std::uint32_t>(to.in_flight.size());
  to.in_flight.insert(to.in_flight.end(), from.in_flight.begin(), from.in_flight.end());
  from.in_flight.clear();
  Event event;
  while (from.queue.pop_before(never, event)) {
    const bool letter = (event.what & (wire_event | unit_event)) == 0 && (event.what & letter_event) != 0;
    to.queue.push(event.time_ns, letter ? event.what + first_letter : event.what);
  }
  ++to.topology_revision;
}

// ---- Running ----

// Whether no lane does what others must see at once: observers, faults that hear frames, a cell that lives elsewhere.
bool Network::may_run_side_by_side() const {
  return workers_ != nullptr && observers_.empty() && acts_.empty() && external_ == nullptr;
}

void Network::run_lanes(std::int64_t end_ns) {
  if (lanes_.size() == 1) return run(lanes_.front(), end_ns);
  lanes_end_ns_ = end_ns;
  lanes_run_ = true;
  try {
    if (may_run_side_by_side())
      workers_->run();
    else
      for (Lane& lane : lanes_) run(lane, end_ns);
  } catch (...) {
    lanes_run_ = false;
    throw;
  }
  lanes_run_ = false;
  hand_over();
}

void Network::send_to_host(Lane& lane, std::size_t unit, std::span<const std::uint8_t> datagram) {
  if (!lanes_run_) return sink_.send(unit, lane.now_ns, datagram);
  lane.outgoing.push_back({lane.now_ns, static_cast<std::uint32_t>(unit),
                           static_cast<std::uint32_t>(lane.outgoing_bytes.size()),
                           static_cast<std::uint32_t>(datagram.size())});
  lane.outgoing_bytes.insert(lane.outgoing_bytes.end(), datagram.begin(), datagram.end());
}

// By time; of equal times those of the first lane first.
void Network::hand_over() {
  std::vector<std::size_t>& next = next_outgoing_;
  next.assign(lanes_.size(), 0);
  for (;;) {
    std::size_t first = lanes_.size();
    for (std::size_t n = 0; n < lanes_.size(); ++n) {
      if (next[n] == lanes_[n].outgoing.size()) continue;
      if (first == lanes_.size() || lanes_[n].outgoing[next[n]].time_ns < lanes_[first].outgoing[next[first]].time_ns)
        first = n;
    }
    if (first == lanes_.size()) break;
    const Lane::Outgoing& datagram = lanes_[first].outgoing[next[first]++];
    sink_.send(datagram.unit, datagram.time_ns,
               std::span(lanes_[first].outgoing_bytes).subspan(datagram.first, datagram.bytes));
  }
  for (Lane& lane : lanes_) {
    lane.outgoing.clear();
    lane.outgoing_bytes.clear();
  }
}

// ---- What is so of all ----

std::int64_t Network::time_ns() const {
  return lanes_.front().now_ns;
}

std::size_t Network::lane_count() const {
  return lanes_.size();
}

NetworkCounts Network::counts() const {
  NetworkCounts sum;
  for (const Lane& lane : lanes_) sum += lane.counts;
  return sum;
}

std::uint64_t Network::topology_revision() const {
  std::uint64_t sum = 0;
  for (const Lane& lane : lanes_) sum += lane.topology_revision;
  return sum;
}

std::uint64_t Network::log_hash() const {
  Lane joined;
  joined.log_hash = lanes_.front().log_hash;
  for (std::size_t n = 1; n < lanes_.size(); ++n) joined.log(lanes_[n].log_hash);
  return joined.log_hash;
}

}  // namespace robotskin::world
