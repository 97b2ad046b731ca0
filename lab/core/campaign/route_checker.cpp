// SPDX-License-Identifier: Apache-2.0
#include "campaign/route_checker.hpp"

#include <algorithm>
#include <utility>

#include "robotskin/timing.h"

namespace robotskin::campaign {
namespace {

constexpr std::int64_t settled_ns = 20 * ms;
constexpr std::int64_t shortest_frame_ns = RS_FRAME_US * us * 97 / 100;
// A cell's clock may run 2 % fast.
constexpr std::int64_t shortest_quarantine_ns = RS_QUARANTINE_US * us * 97 / 100;

// Alone for so long, a cell forgets; its clock may run 2 % fast.
constexpr std::int64_t alone_long_ns = RS_ORPHAN_RESET_US * us * 97 / 100;

// A frame has 63 hops. One that had climbed a tree 40 hops deep may come down again and climb another when the tree's
// root is lost, without any circle; so only a frame that met no change of parents while it lived must not run out. Of a
// sample it is known since when it lives: where a crowd looks for its way it waits long. Another frame lives for 63
// hops, and is kept for 12 ms. Reports and requests wait behind all others, for how long is open; they come again by
// themselves, and what carried them in a circle would carry samples too.
std::int64_t frame_lives_ns(const GroundTruth& ground) {
  return RS_TTL_START * ground.hop_ns() + RS_ARQ_KEEP_US * us;
}

bool is_report(const rs_input& input) {
  if (input.kind != RS_INPUT_FRAME) return false;
  const rs_frame_type type = rs_frame_type_of(input.frame);
  return type == RS_TYPE_topology || type == RS_TYPE_join || type == RS_TYPE_reply;
}

// A sample of no cell, which a fault has put there.
bool is_stuffed(const std::uint8_t* frame) {
  rs_clock clock;
  rs_clock_unpack(&clock, frame);
  return clock.source == RS_ID_NONE;
}

bool comes_after(std::uint16_t a, std::uint16_t b) {
  const auto ahead = static_cast<std::uint16_t>(a - b);
  return ahead != 0 && ahead < 0x8000;
}

}  // namespace

RouteChecker::RouteChecker(const world::Network& network, GroundTruth& ground, BeaconLog& beacons, BreakLog& breaks)
    : network_(network), ground_(ground), beacons_(beacons), breaks_(breaks), shadow_(network.cell_count()) {}

void RouteChecker::copy(std::size_t cell) {
  const rs_route& route = network_.cell(cell).route;
  Shadow& shadow = shadow_[cell];
  shadow.wave = route.wave;
  shadow.hops = route.hops;
  shadow.port = route.parent_port;
  shadow.unbound = route.unbound;
  shadow.feasible_sequence = route.feasible_sequence;
  shadow.feasible_hops = route.feasible_hops;
}

void RouteChecker::frame_taken(std::size_t at_wire, const std::uint8_t* frame, std::int64_t came_ns) {
  const std::int64_t now_ns = network_.time_ns();
  const unsigned type = frame[0] >> 4;
  if (type == RS_TYPE_tick) {
    rs_tick tick;
    rs_tick_unpack(&tick, frame);
    if (!std::exchange(tick_planted_, false)) beacons_.arrived(at_wire, tick, came_ns);
  } else if ((type == RS_TYPE_clock && !is_stuffed(frame)) || type == RS_TYPE_event || type == RS_TYPE_torque) {
    const std::size_t cell = GroundTruth::cell_of(at_wire);
    const Shadow& shadow = shadow_[cell];
    const unsigned port = static_cast<unsigned>(at_wire % RS_PORTS) + 1;
    if (shadow.port != port || ground_.lawless(now_ns, cell)) return;
    // Believed to lead elsewhere, or back only by chance: the plug was moved.
    const std::int32_t far = ground_.far(at_wire);
    if (!ground_.ready(at_wire, now_ns) || far == GroundTruth::no_wire ||
        !ground_.is_cell(static_cast<std::size_t>(far)) ||
        shadow.parent != static_cast<std::int32_t>(GroundTruth::cell_of(static_cast<std::size_t>(far))))
      return;
    breaks_.add(Invariant::hops_left, now_ns, {cell, static_cast<std::size_t>(shadow.parent)},
                {{"sample from own parent at port", port}});
  }
}

void RouteChecker::cell_stepped(std::size_t cell, const rs_input& input, std::optional<std::int64_t> taken_ns) {
  const rs_cell& state = network_.cell(cell);
  const rs_route& route = state.route;
  Shadow& shadow = shadow_[cell];
  if (input.kind == RS_INPUT_BOOT) {
    shadow = {};
    copy(cell);
    for (unsigned port = 1; port <= RS_PORTS; ++port) beacons_.forget(ground_.wire_of_cell(cell, port));
    return;
  }
  if (state.counts.hops_exhausted != shadow.hops_exhausted) {
    shadow.hops_exhausted = state.counts.hops_exhausted;
    const std::int64_t since_ns = taken_ns.value_or(network_.time_ns() - frame_lives_ns(ground_));
    if (!is_report(input) && !ground_.lawless(network_.time_ns(), cell) && since_ns > changed_ns_)
      breaks_.add(Invariant::hops_left, network_.time_ns(), {cell}, {{"out of hops at", route.hops}});
  }
  const bool same_parent = route.parent_port == shadow.port && route.hops == shadow.hops &&
                           route.wave.sequence == shadow.wave.sequence && route.wave.root == shadow.wave.root;
  const bool same_distance = route.feasible_sequence == shadow.feasible_sequence &&
                             route.feasible_hops == shadow.feasible_hops && route.unbound == shadow.unbound;
  if (same_parent && same_distance) return;
  if (!same_parent) {
    if (route.parent_port == RS_NO_PARENT) {
      if (shadow.parent != none) changed_ns_ = shadow.alone_ns = network_.time_ns();
      shadow.parent = none;
    } else {
      adopted(cell, route);
    }
  }
  copy(cell);
  if (ground_.lawless(network_.time_ns(), cell)) return;
  check_order(cell);
  check_children(cell);
}

// A cell has taken over a beacon: from a new parent, or the next one of its parent.
void RouteChecker::adopted(std::size_t cell, const rs_route& route) {
  const std::int64_t now_ns = network_.time_ns();
  Shadow& shadow = shadow_[cell];
  ++adoptions_;
  const bool lawless = ground_.lawless(now_ns, cell);
  const unsigned port = route.parent_port;
  if (port > RS_PORTS) {
    if (!lawless) breaks_.add(Invariant::true_adoption, now_ns, {cell}, {{"parent port", port}});
    return;
  }
  const std::size_t wire = ground_.wire_of_cell(cell, port);
  const std::int32_t far = ground_.far(wire);
  const std::int32_t before = shadow.parent;
  const ArrivedBeacon* beacon = beacons_.find(wire, route.wave.sequence, static_cast<std::uint8_t>(route.hops - 1));
  if (beacon != nullptr && beacon->time_ns < ground_.moved_ns(wire) + shortest_frame_ns) {
    // The cell that said so was there until the plug was moved: no frame is whole so soon after.
    if (port != shadow.port) shadow.parent = none;
  } else if (far == GroundTruth::no_wire) {
    shadow.parent = none;
  } else if (!ground_.is_cell(static_cast<std::size_t>(far))) {
    shadow.parent = unit;
  } else {
    shadow.parent = static_cast<std::int32_t>(GroundTruth::cell_of(static_cast<std::size_t>(far)));
    shadow.boot_of_parent_ns = ground_.booted_ns(static_cast<std::size_t>(shadow.parent));
  }
  if (shadow.parent != before || port != shadow.port) changed_ns_ = now_ns;
  // Without keys a wave that damaged memory has made goes on from cell to cell, as far as it comes until that is over.
  const bool false_wave = beacons_.find(route.wave) == nullptr;
  const bool spread = !network_.cell(cell).keyed && ground_.lawless(now_ns) && shadow.parent >= 0 &&
                      now_ns - shadow_[static_cast<std::size_t>(shadow.parent)].false_ns < settled_ns;
  if (false_wave) shadow.false_ns = now_ns;
  if (!lawless) {
    const auto far_cell = shadow.parent >= 0 ? static_cast<std::size_t>(shadow.parent) : cell;
    if (now_ns - ground_.booted_ns(cell) < shortest_quarantine_ns)
      breaks_.add(Invariant::quarantine, now_ns, {cell}, {{"us since boot", (now_ns - ground_.booted_ns(cell)) / us}});
    const bool knew_time = !shadow.misled && (before != none || now_ns - shadow.alone_ns < alone_long_ns);
    if (beacon != nullptr && beacon->planted && knew_time)
      breaks_.add(Invariant::replayed, now_ns, {cell},
                  {{"port", port}, {"sequence", route.wave.sequence}, {"before", shadow.wave.sequence}});
    if (beacon == nullptr)
      breaks_.add(Invariant::true_adoption, now_ns, {cell, far_cell},
                  {{"port", port},
                   {"hops", route.hops},
                   {"sequence", route.wave.sequence},
                   {"announced hops", beacons_.newest(wire).hops},
                   {"announced sequence", beacons_.newest(wire).sequence}});
    if (beacons_.child(wire))
      breaks_.add(Invariant::own_child, now_ns, {cell, far_cell},
                  {{"port", port}, {"hops", route.hops}, {"sequence", route.wave.sequence}});
    if (false_wave && !spread)
      breaks_.add(Invariant::true_tick, now_ns, {cell},
                  {{"sequence", route.wave.sequence},
                   {"era", route.wave.era},
                   {"root", route.wave.root},
                   {"newest sequence issued", beacons_.newest_time() & 0xFFFF}});
    const auto ahead = static_cast<std::uint16_t>(route.wave.sequence - shadow.wave.sequence);
    if (before != none && now_ns - shadow.advanced_ns < RS_STALE_TICKS * RS_TICK_US * us * 97 / 100 &&
        ahead > RS_SEQUENCE_WINDOW && ahead < 0x8000)
      breaks_.add(Invariant::tick_window, now_ns, {cell},
                  {{"sequence", route.wave.sequence}, {"before", shadow.wave.sequence}});
  }
  // Without a fault to repair, a cell changes trees because it was granted to, or to come nearer.
  const bool settled = now_ns > ground_.repaired_ns() + settled_ns && ground_.calm(now_ns);
  const bool granted =
      before != none && shadow.parent != before && route.wave.root != shadow.wave.root && route.hops >= shadow.hops;
  if (settled && granted && route.hops > std::max(route.wave.depth_cap, shadow.wave.depth_cap))
    breaks_.add(Invariant::depth_cap, now_ns, {cell},
                {{"hops", route.hops}, {"cap", route.wave.depth_cap}, {"before", shadow.hops}});
  if (route.wave.sequence != shadow.wave.sequence) shadow.advanced_ns = now_ns;
  shadow.misled = beacon != nullptr && beacon->planted;
  if (!lawless && shadow.parent != before) check_circle(cell);
}

bool RouteChecker::cannot_know_time(std::size_t cell) const {
  if (shadow_[cell].misled) return true;
  return shadow_[cell].parent == none && network_.time_ns() - shadow_[cell].alone_ns >= alone_long_ns;
}

void RouteChecker::frame_planted(std::size_t at_wire, const std::uint8_t* frame) {
  if (rs_frame_type_of(frame) != RS_TYPE_tick) return;
  rs_tick tick;
  rs_tick_unpack(&tick, frame);
  beacons_.planted(at_wire, tick, network_.time_ns());
  tick_planted_ = true;
}

void RouteChecker::check_circle(std::size_t cell) {
  std::int32_t at = shadow_[cell].parent;
  const std::int64_t now_ns = network_.time_ns();
  for (std::size_t hops = 1; at >= 0 && hops <= shadow_.size(); ++hops) {
    if (ground_.lawless(now_ns, static_cast<std::size_t>(at))) return;
    if (at == static_cast<std::int32_t>(cell)) {
      breaks_.add(Invariant::acyclic, now_ns, {cell, static_cast<std::size_t>(shadow_[cell].parent)},
                  {{"cells in the circle", static_cast<std::int64_t>(hops)}});
      return;
    }
    at = shadow_[static_cast<std::size_t>(at)].parent;
  }
}

void RouteChecker::check_order(std::size_t child) {
  const Shadow& below = shadow_[child];
  if (below.parent < 0) return;
  if (ground_.is_zombie(child)) return;  // adopts nothing; after half the tick numbers its own seems new
  const auto parent = static_cast<std::size_t>(below.parent);
  if (ground_.lawless(network_.time_ns(), child) || ground_.lawless(network_.time_ns(), parent)) return;
  const Shadow& above = shadow_[parent];
  // A parent that has none itself can close no circle; one that has lost its memory must be let go before it has.
  if (above.parent == none) return;
  const bool before =
      !above.unbound && !below.unbound &&
      (comes_after(above.feasible_sequence, below.feasible_sequence) ||
       (above.feasible_sequence == below.feasible_sequence && above.feasible_hops < below.feasible_hops));
  if (before) return;
  breaks_.add(Invariant::distance_order, network_.time_ns(), {parent, child},
              {{"parent's sequence", above.feasible_sequence},
               {"hops", above.feasible_hops},
               {"child's sequence", below.feasible_sequence},
               {"hops", below.feasible_hops},
               {"parent booted since", ground_.booted_ns(parent) != below.boot_of_parent_ns}});
}

void RouteChecker::check_children(std::size_t cell) {
  for (unsigned port = 1; port <= RS_PORTS; ++port) {
    const std::int32_t far = ground_.far(ground_.wire_of_cell(cell, port));
    if (far == GroundTruth::no_wire || !ground_.is_cell(static_cast<std::size_t>(far))) continue;
    const std::size_t other = GroundTruth::cell_of(static_cast<std::size_t>(far));
    if (shadow_[other].parent == static_cast<std::int32_t>(cell)) check_order(other);
  }
}

void RouteChecker::settle() {
  for (std::size_t cell = 0; cell < shadow_.size(); ++cell)
    if (!ground_.runs(cell) && shadow_[cell].parent != none) {
      shadow_[cell].parent = none;
      changed_ns_ = network_.time_ns();
    }
}

void RouteChecker::check_all() {
  for (std::size_t cell = 0; cell < shadow_.size(); ++cell) {
    if (shadow_[cell].parent == none) continue;
    check_circle(cell);
    check_order(cell);
  }
}

}  // namespace robotskin::campaign
