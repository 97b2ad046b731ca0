// SPDX-License-Identifier: Apache-2.0
#include "campaign/ground_truth.hpp"

#include <algorithm>

namespace robotskin::campaign {
namespace {

using world::Fault;
using world::WireEnd;

// Three frames of a heartbeat each, on clocks 2 % apart.
constexpr std::int64_t link_up_ns = 4 * ms;
constexpr std::int64_t longest_quarantine_ns = RS_QUARANTINE_US * us * 102 / 100;
constexpr std::int64_t zombie_ns =
    RS_STALE_US * us + 2 * RS_STALE_TICKS * RS_TICK_US * us;  // noticed by standing still

// A link lost for the n-th time is kept out for longer and longer.
std::int64_t hold_ns(std::int32_t downs) {
  if (downs < 2) return 0;
  return std::min<std::int64_t>(std::int64_t{RS_HOLD_DOWN_US} << std::min(downs - 2, 16), RS_HOLD_DOWN_MAX_US) * us;
}

}  // namespace

GroundTruth::GroundTruth(const world::Network& network, ProcessingTimes times, double frame_loss)
    : network_(network),
      times_(times),
      frame_loss_(frame_loss),
      cells_(network.cell_count()),
      far_(RS_PORTS * cells_ + RS_SECTION_UNIT_PORTS_MAX * network.unit_count(), no_wire),
      downs_(far_.size()),
      forged_(far_.size()),
      joined_(far_.size()),
      ready_ns_(far_.size()),
      moved_ns_(far_.size()),
      heard_ns_(far_.size(), -1000 * ms),
      runs_(cells_),
      zombie_(cells_),
      booted_ns_(cells_, -1),
      shaken_until_ns_(cells_, -1000 * ms),
      lawless_cell_ns_(cells_),
      depth_(cells_) {
  for (std::size_t wire = 0; wire < far_.size(); ++wire) look_at(wire);
}

// What a wire joins now, and whether that is new.
void GroundTruth::look_at(std::size_t wire) {
  WireEnd end{WireEnd::At::cell, static_cast<std::uint8_t>(wire % RS_PORTS + 1),
              static_cast<std::uint32_t>(wire / RS_PORTS)};
  if (!is_cell(wire)) {
    const std::size_t at = wire - RS_PORTS * cells_;
    end = {WireEnd::At::unit, static_cast<std::uint8_t>(at % RS_SECTION_UNIT_PORTS_MAX + 1),
           static_cast<std::uint32_t>(at / RS_SECTION_UNIT_PORTS_MAX)};
    if (end.port > network_.wiring().units[end.index].ports.size()) return;
  }
  const WireEnd other = network_.other_end(end);
  const std::int32_t far = other.at == WireEnd::At::nothing ? no_wire : static_cast<std::int32_t>(wire_of(other));
  bool joined = far != no_wire && network_.carries(end) && network_.carries(other);
  for (const WireEnd& side : {end, other})
    if (side.at == WireEnd::At::unit)
      joined = joined && network_.unit_runs(side.index) && network_.port_powered(side.index, side.port);
  const bool moved = far != far_[wire];
  far_[wire] = far;
  if (moved) moved_ns_[wire] = network_.time_ns();
  const bool was_joined = joined_[wire] != 0;
  joined_[wire] = joined;
  if (joined == was_joined && !(moved && joined)) return;
  ++revision_;
  if (was_joined) ++downs_[wire];
  if (!joined) return;
  const std::int32_t downs = std::max(downs_[wire], far == no_wire ? 0 : downs_[static_cast<std::size_t>(far)]);
  // A port that wrong tags have closed stays so, whatever becomes of its line.
  const bool closed = tags_spent(wire) || (far != no_wire && tags_spent(static_cast<std::size_t>(far)));
  ready_ns_[wire] = std::max(closed ? ready_ns_[wire] : 0, network_.time_ns() + link_up_ns + hold_ns(downs));
}

// A wire whose link goes down although both its ends run.
void GroundTruth::shake(std::size_t wire, std::int64_t for_ns, std::int32_t downs) {
  for (const std::int32_t side : {static_cast<std::int32_t>(wire), far_[wire]}) {
    if (side == no_wire) continue;
    const auto at = static_cast<std::size_t>(side);
    downs_[at] += downs;
    ready_ns_[at] =
        std::max(ready_ns_[at], network_.time_ns() + for_ns + (downs > 0 ? link_up_ns + hold_ns(downs_[at]) : 0));
  }
  ++revision_;
}

void GroundTruth::expect(const std::vector<Fault>& faults) {
  for (const Fault& fault : faults)
    if (world::type_of(fault).truth.overwrites_memory) overwritten_ns_.push_back(fault.time_ns);
  std::ranges::sort(overwritten_ns_, std::greater<>());
  if (!overwritten_ns_.empty()) next_overwritten_ns_ = overwritten_ns_.back();
}

void GroundTruth::disturb(std::int64_t for_ns, std::int64_t repair, bool elsewhere) {
  const std::int64_t end_ns = network_.time_ns() + for_ns;
  waits_ = end_ns < moving_until_ns_ || (waits_ && network_.time_ns() < repaired_ns());
  disturbed_ns_ = std::max(disturbed_ns_, end_ns);
  restless_until_ns_ = std::max(restless_until_ns_, end_ns);
  base_ns_ = std::max(base_ns_, end_ns + repair);
  repaired_ns_ = std::max(repaired_ns_, base_ns_);
  samples_disturbed_ns_ = std::max(samples_disturbed_ns_, end_ns + repair);
  if (!elsewhere) return;
  elsewhere_.restless_until_ns = std::max(elsewhere_.restless_until_ns, end_ns);
  elsewhere_.base_ns = std::max(elsewhere_.base_ns, end_ns + repair);
  elsewhere_.repaired_ns = std::max(elsewhere_.repaired_ns, elsewhere_.base_ns);
}

std::int64_t GroundTruth::catch_up_ns(std::int64_t now_ns) const {
  const std::int64_t lately_ns = now_ns - times_.catch_up_ns - longest_quarantine_ns;
  const auto booted = std::ranges::count_if(booted_ns_, [&](std::int64_t at_ns) { return at_ns > lately_ns; });
  return times_.catch_up_ns * std::min<std::int64_t>(booted, RS_CELLS_PER_PORT) / RS_CELLS_PER_PORT;
}

void GroundTruth::untold() {
  disturb(0, repair_ns());
}

void GroundTruth::planted(std::size_t wire) {
  if (far_[wire] != no_wire && !joined_[wire]) disturb(0, repair_ns());
}

void GroundTruth::forged(std::size_t wire) {
  if (++forged_[wire] <= RS_TAGS_BUDGET) return;
  shake(wire, std::int64_t{RS_TAGS_CLOSED_S} * 1000 * ms, 1);
  disturb(0, repair_ns());
}

void GroundTruth::granted() {
  // Until it has come to the cell it is for, on the longest way.
  moving_until_ns_ = network_.time_ns() + RS_HOPS_MAX * hop_ns() + held_ns;
  waits_ = waits_ || network_.time_ns() < repaired_ns_;
}

void GroundTruth::frame_ended(std::size_t wire, bool whole) {
  const std::int64_t now_ns = network_.time_ns(), silent_ns = now_ns - heard_ns_[wire];
  if (whole) {
    heard_ns_[wire] = now_ns;
    return;
  }
  // The next frame may come a heartbeat later. A link that has fallen does not fall again.
  constexpr std::int64_t longest_ns = (RS_LINK_DOWN_US - RS_HEARTBEAT_US) * us * 98 / 100;
  if (!joined_[wire] || silent_ns < longest_ns || silent_ns > RS_LINK_DOWN_US * us) return;
  heard_ns_[wire] = -1000 * ms;
  shake(wire, RS_HEARTBEAT_US * us, 1);
  disturb(RS_HEARTBEAT_US * us, repair_ns());
}

void GroundTruth::booted(std::size_t cell) {
  booted_ns_[cell] = network_.time_ns();
  runs_[cell] = 1;
  zombie_[cell] = 0;
  for (unsigned port = 1; port <= RS_PORTS; ++port) {
    const std::size_t wire = wire_of_cell(cell, port);
    look_at(wire);
    if (far_[wire] != no_wire) look_at(static_cast<std::size_t>(far_[wire]));
    shake(wire, longest_quarantine_ns + link_up_ns, 0);
  }
  disturb(0, repair_ns());
}

void GroundTruth::misled() {
  disturb(0, repair_ns() + RS_STALE_LIMIT_US * us);
}

std::vector<std::size_t> GroundTruth::wires_of(const Fault& fault) const {
  std::vector<std::size_t> wires;
  for (std::size_t wire = 0; wire < far_.size(); ++wire) {
    const bool cell = is_cell(wire);
    const std::size_t at = cell ? wire : wire - RS_PORTS * cells_;
    const std::size_t ports = cell ? std::size_t{RS_PORTS} : std::size_t{RS_SECTION_UNIT_PORTS_MAX};
    const bool named = fault.cell < 0 && fault.unit < 0;
    const bool mine = (cell ? fault.cell : fault.unit) == static_cast<std::int32_t>(at / ports) &&
                      (fault.port == 0 || fault.port == static_cast<std::int32_t>(at % ports) + 1);
    if (far_[wire] != no_wire && (named || mine)) wires.push_back(wire);
  }
  return wires;
}

void GroundTruth::fault(const Fault& fault, int phase) {
  if (const auto tell = world::type_of(fault).tell) tell(fault, phase % 2 == 0, *this);
}

// ---- What faults tell ----

void GroundTruth::disturbed(std::int64_t for_ns, std::int64_t longer_ns) {
  disturb(for_ns, repair_ns() + longer_ns);
}

void GroundTruth::links_fall(const Fault& fault, std::int64_t for_ns, std::int32_t downs) {
  for (const std::size_t wire : wires_of(fault)) shake(wire, for_ns, downs);
}

// With the rest of a tick that may be too long for a link, by a clock that runs fast.
void GroundTruth::silent(const Fault& fault, std::int64_t for_ns) {
  constexpr std::int64_t noticed_ns = (RS_LINK_DOWN_US - RS_TICK_US) * us * 4 / 5;
  if (for_ns > noticed_ns) links_fall(fault, for_ns, 1);
}

void GroundTruth::links_of_cell_fall(std::size_t cell, std::int64_t for_ns, std::int32_t downs) {
  shaken_until_ns_[cell] = std::max(shaken_until_ns_[cell], network_.time_ns() + for_ns);
  for (unsigned port = 1; port <= RS_PORTS; ++port) shake(wire_of_cell(cell, port), for_ns, downs);
}

void GroundTruth::processor_stuck(std::size_t cell, bool stuck) {
  zombie_[cell] = stuck && runs_[cell];
  disturb(0, repair_ns() + zombie_ns);
}

void GroundTruth::memory_overwritten(std::size_t cell) {
  links_of_cell_fall(cell, legal_again_ns, 1);
  disturb(legal_again_ns, 0, false);
  lawless_until_ns_ = std::max(lawless_until_ns_, network_.time_ns() + legal_again_ns);
  ++memory_faults_;
  std::vector<std::size_t> near{cell};
  std::vector<std::uint8_t> seen(cells_);
  seen[cell] = 1;
  for (int wires = 0; !near.empty(); ++wires) {
    std::vector<std::size_t> next;
    for (const std::size_t one : near) {
      lawless_cell_ns_[one] = lawless_until_ns_;
      for (unsigned port = 1; port <= RS_PORTS && wires < memory_reach; ++port) {
        const std::int32_t far = far_[wire_of_cell(one, port)];
        if (far == no_wire || !is_cell(static_cast<std::size_t>(far))) continue;
        const std::size_t other = cell_of(static_cast<std::size_t>(far));
        if (seen[other]++ == 0) next.push_back(other);
      }
    }
    near = std::move(next);
  }
  while (!overwritten_ns_.empty() && overwritten_ns_.back() <= network_.time_ns()) overwritten_ns_.pop_back();
  if (!overwritten_ns_.empty()) next_overwritten_ns_ = overwritten_ns_.back();
}

void GroundTruth::samples_disturbed(std::int64_t for_ns) {
  samples_disturbed_ns_ = std::max(samples_disturbed_ns_, network_.time_ns() + for_ns);
}

void GroundTruth::settle() {
  for (std::size_t cell = 0; cell < cells_; ++cell) {
    if (zombie_[cell]) continue;
    runs_[cell] = network_.alive(cell);
  }
  for (std::size_t wire = 0; wire < far_.size(); ++wire) look_at(wire);
}

const std::vector<std::int32_t>& GroundTruth::reach(std::int64_t now_ns, std::int64_t margin_ns) {
  const std::int64_t since_ns = now_ns - margin_ns;
  if (depth_revision_ == revision_ && since_ns >= depth_since_ns_ && since_ns < next_ready_ns_) return depth_;
  depth_revision_ = revision_;
  depth_since_ns_ = since_ns;
  next_ready_ns_ = std::numeric_limits<std::int64_t>::max();
  std::ranges::fill(depth_, -1);
  queue_.clear();
  const auto enter = [&](std::size_t wire, std::int32_t hops) {
    if (!joined_[wire]) return;
    const auto far = static_cast<std::size_t>(far_[wire]);
    if (!is_cell(far)) return;
    const std::int64_t ready_ns = std::max(ready_ns_[wire], ready_ns_[far]);
    if (ready_ns > since_ns) {
      next_ready_ns_ = std::min(next_ready_ns_, ready_ns);
      return;
    }
    const std::size_t cell = cell_of(far);
    if (depth_[cell] >= 0 || zombie_[cell] || hops > RS_HOPS_MAX) return;
    depth_[cell] = hops;
    queue_.push_back(static_cast<std::int32_t>(cell));
  };
  for (std::size_t wire = RS_PORTS * cells_; wire < far_.size(); ++wire) enter(wire, 1);
  for (std::size_t at = 0; at < queue_.size(); ++at) {
    const auto cell = static_cast<std::size_t>(queue_[at]);
    for (unsigned port = 1; port <= RS_PORTS; ++port) enter(wire_of_cell(cell, port), depth_[cell] + 1);
  }
  return depth_;
}

}  // namespace robotskin::campaign
