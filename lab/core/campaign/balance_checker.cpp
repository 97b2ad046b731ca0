// SPDX-License-Identifier: Apache-2.0
#include "campaign/balance_checker.hpp"

#include <algorithm>

namespace robotskin::campaign {
namespace {

// Demands come down from cell to cell. One that waits for its id has no turn either: it cannot check the tags of what
// comes down, and passes nothing of it on.
bool hears_demands(const world::Network& network, const RouteChecker& routes, std::size_t cell) {
  return !routes.any_on_way(cell, [&](std::size_t at) {
    const rs_cell& here = network.cell(at);
    return here.id == RS_ID_NONE || (here.keyed && here.turn == RS_TURN_NONE);
  });
}

}  // namespace

void BalanceChecker::granted(const world::Network& network, const RouteChecker& routes, const std::uint8_t* frame) {
  rs_grant grant;
  rs_grant_unpack(&grant, frame);
  if (grant.cell == RS_ID_NONE) return;
  // All whose way leads through the cell: more than that cannot move with it.
  std::uint32_t below = 0;
  for (std::size_t cell = 0; cell < network.cell_count(); ++cell)
    below += routes.any_on_way(cell, [&](std::size_t at) { return network.cell(at).id == grant.cell; });
  recent_[grants_++ % recent_.size()] = {network.time_ns(), static_cast<std::uint8_t>(grant.target_root), below};
}

void BalanceChecker::weigh(std::int64_t now_ns, std::span<const std::uint32_t> loads, bool undisturbed) {
  std::uint32_t cells = 0, trees = 0, fullest = 0;
  std::size_t root = 0;
  std::uint64_t squares = 0;
  for (std::size_t r = 0; r < loads.size(); ++r) {
    cells += loads[r];
    trees += loads[r] > 0;
    squares += std::uint64_t{loads[r]} * loads[r];
    if (loads[r] <= fullest) continue;
    fullest = loads[r];
    root = r;
  }
  if (!undisturbed || cells != cells_ || trees == 0) {
    since_ns_ = undisturbed ? now_ns : -1;
    squares_before_ = squares;
  } else if (since_ns_ >= 0 && fullest > fullest_) {
    std::uint32_t granted = 0;
    for (const Grant& grant : recent_)
      if (grant.target == root && now_ns - grant.time_ns < under_way_ns) granted += grant.cells;
    const std::uint32_t mean = (cells + trees - 1) / trees;
    if (fullest > mean + granted)
      breaks_.add(Invariant::levelling_bound, now_ns, {},
                  {{"root", static_cast<std::int64_t>(root)},
                   {"cells", fullest},
                   {"fullest before", fullest_},
                   {"mean", mean},
                   {"granted to it", granted}});
  }
  cells_ = cells;
  fullest_ = fullest;
  squares_ = squares;
}

unsigned BalanceChecker::port_to_smaller(const world::Network& network, const GroundTruth& ground,
                                         std::span<const std::uint32_t> loads, std::size_t cell) const {
  const rs_route& route = network.cell(cell).route;
  const std::int64_t long_ago_ns = network.time_ns() - grant_within_ns;
  for (unsigned port = 1; port <= RS_PORTS; ++port) {
    const std::size_t wire = ground.wire_of_cell(cell, port);
    if (!ground.ready(wire, long_ago_ns) || ground.tags_spent(wire)) continue;
    const auto far = static_cast<std::size_t>(ground.far(wire));
    if (!ground.is_cell(far) || !ground.ready(far, long_ago_ns) || ground.tags_spent(far)) continue;
    const rs_route& beside = network.cell(GroundTruth::cell_of(far)).route;
    const unsigned root = beside.wave.root, hops = beside.hops + 1U;
    if (beside.parent_port == RS_NO_PARENT || root == route.wave.root || root >> 4U != route.wave.root >> 4U) continue;
    const bool near = hops <= route.wave.depth_cap && hops < std::uint32_t{route.hops} + route.wave.gain_threshold;
    if (near && loads[root] + 2 <= loads[route.wave.root]) return port;
  }
  return 0;
}

void BalanceChecker::weigh_chances(const world::Network& network, const GroundTruth& ground, const RouteChecker& routes,
                                   const RecoveryChecker& recovery, bool undisturbed) {
  const std::int64_t now_ns = network.time_ns();
  std::vector<std::uint32_t> loads(256);  // by root; what is stuck, and what hangs on that, is in no tree
  std::vector<bool> leaf(network.cell_count(), true);
  for (std::size_t cell = 0; cell < leaf.size(); ++cell) {
    if (routes.parent(cell) >= 0) leaf[static_cast<std::size_t>(routes.parent(cell))] = false;
    if (ground.runs(cell) && recovery.has_path(cell)) ++loads[network.cell(cell).route.wave.root];
  }
  std::size_t cell = 0;
  unsigned port = 0;
  for (; undisturbed && grants_ == grants_then_ && cell < leaf.size(); ++cell) {
    const rs_cell& here = network.cell(cell);
    const bool may = leaf[cell] && ground.runs(cell) && recovery.has_path(cell) && hears_demands(network, routes, cell);
    if (!may || here.route.parent_port == RS_NO_PARENT || here.route.hops <= 1 || here.route.wave.forming != 0)
      continue;
    port = port_to_smaller(network, ground, loads, cell);
    if (port != 0) break;
  }
  grants_then_ = grants_;
  if (port == 0) {
    idle_ns_ = -1;
    return;
  }
  if (idle_ns_ < 0) idle_ns_ = now_ns;
  if (now_ns - idle_ns_ <= grant_within_ns) return;
  breaks_.add(Invariant::levelling_progress, now_ns, {cell},
              {{"port to a smaller tree", port},
               {"cells of its own", loads[network.cell(cell).route.wave.root]},
               {"ms without a grant", (now_ns - idle_ns_) / ms}});
  idle_ns_ = now_ns;
}

void BalanceChecker::finish(std::int64_t now_ns) {
  if (since_ns_ < 0 || now_ns - since_ns_ < 100 * ms || squares_ <= squares_before_) return;
  breaks_.add(Invariant::levelling_progress, now_ns, {},
              {{"sum of squares", static_cast<std::int64_t>(squares_)},
               {"before", static_cast<std::int64_t>(squares_before_)},
               {"ms ago", (now_ns - since_ns_) / ms}});
}

}  // namespace robotskin::campaign
