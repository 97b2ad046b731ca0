// SPDX-License-Identifier: Apache-2.0
#include "campaign/recovery_checker.hpp"

#include <algorithm>
#include <limits>

#include "campaign/fault_case.hpp"

namespace robotskin::campaign {
namespace {

constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t fault_free_ns = 20 * ms;  // from then on nothing is a repair any more
constexpr std::int64_t word_ns = 4 * ms;         // two beacons, the second of which may have been lost, and their way

// From the last boot: the quarantine, and two ticks down the deepest tree, each hop of which takes its processor's
// time. With more cells than the cables carry each processor has another input in hand.
std::int64_t formation_ns(const world::Network& network, const GroundTruth& ground) {
  std::size_t ports = 0;
  for (const auto& unit : network.wiring().units) ports += unit.ports.size();
  const bool crowded = network.cell_count() > RS_CELLS_PER_PORT * ports;
  return 10 * ms + hops_max * (ground.hop_ns() - idle_hop_ns + (crowded ? ground.longest_input_ns() : 0));
}

}  // namespace

RecoveryChecker::RecoveryChecker(const world::Network& network, GroundTruth& ground, RouteChecker& routes,
                                 BreakLog& breaks, bool clean_lines)
    : network_(network),
      ground_(ground),
      routes_(routes),
      breaks_(breaks),
      clean_lines_(clean_lines),
      path_(network.cell_count()),
      at_port_(network.cell_count()),
      ways_(network.cell_count()),
      trees_(RS_SECTION_UNIT_PORTS_MAX * network.unit_count()),
      sizes_(network, breaks, clean_lines),
      path_since_ns_(network.cell_count(), never),
      nearer_since_ns_(network.cell_count(), never),
      affected_until_ns_(network.cell_count()),
      affected_after_ns_(hops_max * ground.hop_ns()),
      whole_since_ns_(never) {}

RecoveryChecker::Path RecoveryChecker::path_of(std::size_t cell) {
  trail_.clear();
  Path result = Path::unknown;
  std::size_t at_port = 0;
  for (std::size_t at = cell; result == Path::unknown;) {
    if (path_[at] != Path::unknown) {
      result = path_[at];
      at_port = at_port_[at];
      break;
    }
    trail_.push_back(static_cast<std::int32_t>(at));
    const std::int32_t parent = routes_.parent(at);
    const unsigned port = routes_.parent_port(at);
    if (parent == RouteChecker::none || port == 0 || port > RS_PORTS || trail_.size() > path_.size() ||
        ground_.is_zombie(at) || !ground_.joined(ground_.wire_of_cell(at, port))) {
      result = Path::broken;
      break;
    }
    const auto far = static_cast<std::size_t>(ground_.far(ground_.wire_of_cell(at, port)));
    if (parent == RouteChecker::unit) {
      result = ground_.is_cell(far) ? Path::broken : Path::whole;
      if (result == Path::whole) at_port = far - RS_PORTS * path_.size();
    } else if (!ground_.is_cell(far) || static_cast<std::int32_t>(GroundTruth::cell_of(far)) != parent) {
      result = Path::broken;
    } else {
      at = static_cast<std::size_t>(parent);
    }
  }
  for (const std::int32_t passed : trail_) {
    path_[static_cast<std::size_t>(passed)] = result;
    at_port_[static_cast<std::size_t>(passed)] = at_port;
  }
  return result;
}

void RecoveryChecker::follow_paths() {
  std::ranges::fill(path_, Path::unknown);
  attached_ = 0;
  for (std::size_t cell = 0; cell < path_.size(); ++cell)
    if (ground_.runs(cell) && path_of(cell) == Path::whole) ++attached_;
  for (std::size_t cell = 0; cell < path_.size(); ++cell)
    path_since_ns_[cell] = has_path(cell) ? std::min(path_since_ns_[cell], network_.time_ns()) : never;
}

bool RecoveryChecker::leads_through_damage(std::size_t cell) const {
  const std::int64_t now_ns = network_.time_ns();
  return routes_.any_on_way(cell, [&](std::size_t at) { return ground_.lawless(now_ns, at); });
}

// Which cells damaged memory may concern: while it is near, while their way leads through there, and if they lose it,
// until they have another.
void RecoveryChecker::spread_damage() {
  for (std::size_t cell = 0; cell < path_.size(); ++cell)
    if (leads_through_damage(cell) || (affected_until_ns_[cell] > 0 && path_[cell] != Path::whole))
      affected_until_ns_[cell] = ground_.lawless_until_ns();
}

// Cells that have nothing to do with the damage keep their ways, or are back as soon as after any other fault.
void RecoveryChecker::check_elsewhere() {
  const std::int64_t now_ns = network_.time_ns();
  if (now_ns < ground_.repaired_elsewhere_ns() || !ground_.calm_elsewhere(now_ns)) return;
  const std::vector<std::int32_t>& reach = ground_.reach(now_ns, ground_.repair_ns() + hops_max * ground_.hop_ns());
  for (std::size_t cell = 0; cell < path_.size(); ++cell) {
    if (reach[cell] < 0 || path_[cell] == Path::whole || affected(cell) || told_elsewhere_) continue;
    told_elsewhere_ = true;
    breaks_.add(Invariant::rejoined, now_ns, {cell},
                {{"hops away", reach[cell]}, {"parent port", routes_.parent_port(cell)}, {"memory damaged", 1}});
  }
}

// The repair enters the part that was cut off from those that still have their paths.
void RecoveryChecker::struck(bool everywhere, bool overloaded) {
  struck_ = true;
  repairing_ = true;
  told_ = false;
  told_elsewhere_ = false;
  whole_since_ns_ = never;
  std::ranges::fill(nearer_since_ns_, never);
  follow_paths();
  if (ground_.lawless(network_.time_ns())) spread_damage();
  std::vector<std::int32_t> distance(path_.size(), -1);
  std::vector<std::size_t> queue;
  const auto enter = [&](std::size_t cell, std::int32_t hops) {
    if (distance[cell] >= 0 || !ground_.runs(cell) || ground_.is_zombie(cell)) return;
    distance[cell] = hops;
    queue.push_back(cell);
  };
  for (std::size_t wire = RS_PORTS * path_.size(); wire < ground_.wire_count(); ++wire)
    if (ground_.joined(wire)) enter(GroundTruth::cell_of(static_cast<std::size_t>(ground_.far(wire))), 1);
  if (!everywhere)
    for (std::size_t cell = 0; cell < path_.size(); ++cell)
      if (path_[cell] == Path::whole) enter(cell, 0);
  std::int32_t farthest = 0;
  for (std::size_t at = 0; at < queue.size(); ++at) {
    const std::size_t cell = queue[at];
    farthest = std::max(farthest, distance[cell]);
    for (unsigned port = 1; port <= RS_PORTS; ++port) {
      const std::size_t wire = ground_.wire_of_cell(cell, port);
      if (!ground_.joined(wire) || !ground_.is_cell(static_cast<std::size_t>(ground_.far(wire)))) continue;
      enter(GroundTruth::cell_of(static_cast<std::size_t>(ground_.far(wire))), distance[cell] + 1);
    }
  }
  std::int32_t deepest_lost = 0;
  for (std::size_t cell = 0; cell < path_.size(); ++cell)
    if (ground_.runs(cell) && path_[cell] != Path::whole && routes_.hops(cell) < RS_HOPS_POISON)
      deepest_lost = std::max<std::int32_t>(deepest_lost, routes_.hops(cell));
  ground_.allow_hops(farthest, deepest_lost, overloaded);
}

void RecoveryChecker::poll() {
  const std::int64_t now_ns = network_.time_ns();
  if (ground_.lawless(now_ns)) {
    was_lawless_ = true;
    whole_since_ns_ = never;
    follow_paths();
    spread_damage();
    check_elsewhere();
    return;
  }
  if (was_lawless_) {
    was_lawless_ = false;
    const std::uint64_t before = breaks_.count();
    routes_.check_all();
    if (breaks_.count() != before)
      breaks_.add(Invariant::legal_again, now_ns, {}, {{"false", static_cast<std::int64_t>(breaks_.count() - before)}});
  }
  follow_paths();
  // What has been reachable for as long as a tick needs to get there.
  const std::vector<std::int32_t>& reach = ground_.reach(now_ns, ground_.repair_ns() + hops_max * ground_.hop_ns());
  std::size_t lost = path_.size(), lost_count = 0;
  std::int32_t deepest = 0;
  for (std::size_t cell = 0; cell < path_.size(); ++cell) {
    deepest = std::max(deepest, reach[cell]);
    if (reach[cell] < 0 || path_[cell] == Path::whole) continue;
    lost = cell;
    ++lost_count;
  }
  if (lost_count == 0) {
    if (repairing_ && struck_ && ground_.calm(now_ns))
      longest_repair_ns_ = std::max(longest_repair_ns_, now_ns - ground_.disturbed_ns());
    repairing_ = false;
    told_ = false;
    whole_since_ns_ = std::min(whole_since_ns_, now_ns);
  } else {
    whole_since_ns_ = never;
    if (now_ns >= ground_.repaired_ns() && ground_.calm(now_ns) && !told_) {
      told_ = true;
      const std::int64_t since_ns = now_ns - ground_.disturbed_ns();
      const bool by_memory = ground_.lawless_until_ns() > 0 && now_ns - ground_.lawless_until_ns() < fault_free_ns;
      breaks_.add(by_memory                  ? Invariant::legal_again
                  : since_ns < fault_free_ns ? Invariant::recovery
                                             : Invariant::rejoined,
                  now_ns, {lost},
                  {{"cells without a path", static_cast<std::int64_t>(lost_count)},
                   {"us since the disturbance", since_ns / us},
                   {"us allowed", (ground_.repaired_ns() - ground_.disturbed_ns()) / us},
                   {"hops away", reach[lost]},
                   {"parent port", routes_.parent_port(lost)}});
    }
    return;
  }
  check_formation();
  if (now_ns >= ground_.repaired_ns() + fault_free_ns) {
    if (now_ns >= routes_.changed_ns() + fault_free_ns)
      check_nearest();
    else
      std::ranges::fill(nearer_since_ns_, never);
    sizes_.weigh(count_trees());
  }
}

void RecoveryChecker::check_formation() {
  const std::int64_t now_ns = network_.time_ns();
  if (formation_checked_ || struck_ || !clean_lines_ ||
      now_ns < ground_.disturbed_ns() + formation_ns(network_, ground_))
    return;
  formation_checked_ = true;
  const std::vector<std::int32_t> depths = network_.depths();
  for (std::size_t cell = 0; cell < path_.size(); ++cell) {
    const rs_route& route = network_.cell(cell).route;
    if (depths[cell] < 0 || route.wave.forming == 0) continue;
    if (route.hops != depths[cell])
      breaks_.add(Invariant::shortest, now_ns, {cell}, {{"hops", route.hops}, {"distance", depths[cell]}});
  }
}

// Whether the rule keeps a cell from going back to a nearer neighbour: that is to become light, and the cell's own
// parent is not, nor the cell or what hangs on it too deep.
bool RecoveryChecker::stays_away(const rs_route& route, unsigned port) const {
  const rs_neighbour& parent = route.neighbour[(route.parent_port - 1U) % RS_PORTS];
  return route.neighbour[port - 1].draining && !parent.draining &&
         route.hops + route.subtree_height <= route.wave.depth_cap;
}

// In a settled tree no cell stays away from a nearer parent of its own root for longer than word of it takes.
void RecoveryChecker::check_nearest() {
  const std::int64_t now_ns = network_.time_ns();
  for (std::size_t cell = 0; cell < path_.size(); ++cell) {
    const unsigned port = path_[cell] == Path::whole ? nearer_port(cell) : 0;
    if (port == 0) {
      nearer_since_ns_[cell] = never;
      continue;
    }
    nearer_since_ns_[cell] = std::min(nearer_since_ns_[cell], now_ns);
    if (now_ns - nearer_since_ns_[cell] < word_ns) continue;
    nearer_since_ns_[cell] = now_ns;
    const std::size_t other =
        GroundTruth::cell_of(static_cast<std::size_t>(ground_.far(ground_.wire_of_cell(cell, port))));
    breaks_.add(
        Invariant::depth_cap, now_ns, {cell, other},
        {{"hops", network_.cell(cell).route.hops}, {"beside", network_.cell(other).route.hops}, {"port", port}});
  }
}

// The port to a cell that would be a nearer parent of the same root, and that the rule lets it go to; 0: none.
unsigned RecoveryChecker::nearer_port(std::size_t cell) const {
  const std::int64_t ready_ns = network_.time_ns() - fault_free_ns;
  const rs_route& route = network_.cell(cell).route;
  for (unsigned port = 1; port <= RS_PORTS; ++port) {
    const std::size_t wire = ground_.wire_of_cell(cell, port);
    if (!ground_.ready(wire, ready_ns)) continue;
    const auto far = static_cast<std::size_t>(ground_.far(wire));
    if (!ground_.is_cell(far) || !ground_.ready(far, ready_ns)) continue;
    const std::size_t other = GroundTruth::cell_of(far);
    const rs_route& beside = network_.cell(other).route;
    if (path_[other] != Path::whole || beside.wave.root != route.wave.root || beside.hops + 1 >= route.hops) continue;
    const rs_neighbour& back = beside.neighbour[far % RS_PORTS];
    if (back.hold_down && !back.up) continue;  // nothing hangs on a link that is held down
    if (!stays_away(route, port)) return port;
  }
  return 0;
}

void RecoveryChecker::note_moves() {
  for (std::size_t cell = 0; cell < path_.size(); ++cell) {
    if (path_[cell] != Path::whole) continue;
    Way& way = ways_[cell];
    const std::int32_t parent = routes_.parent(cell);
    if (parent != way.parent && at_port_[cell] == way.at_port) way.moved_ns = network_.time_ns();
    way.parent = parent;
    way.at_port = at_port_[cell];
  }
}

// Whether the cell, or one that its way leads over, has taken another parent in its tree since then.
bool RecoveryChecker::moved_within_tree(std::size_t cell, std::int64_t since_ns) const {
  return routes_.any_on_way(cell, [&](std::size_t at) { return ways_[at].moved_ns > since_ns; });
}

// By the port of a section unit that the ways of its cells lead to.
const std::vector<TreeSizeChecker::Tree>& RecoveryChecker::count_trees() {
  std::ranges::fill(trees_, TreeSizeChecker::Tree{});
  for (std::size_t cell = 0; cell < path_.size(); ++cell) {
    if (!ground_.runs(cell) || path_[cell] != Path::whole) continue;
    TreeSizeChecker::Tree& tree = trees_[at_port_[cell]];
    ++tree.cells;
    tree.deepest = std::max(tree.deepest, static_cast<std::int32_t>(routes_.hops(cell)));
  }
  note_moves();
  for (std::size_t cell = 0; cell < path_.size(); ++cell) {
    if (!ground_.runs(cell) || path_[cell] != Path::whole) continue;
    TreeSizeChecker::Tree& tree = trees_[at_port_[cell]];
    const std::int64_t since_ns = network_.time_ns() - sizes_.word_ns(tree.deepest);
    if (routes_.changed_ns() > since_ns && moved_within_tree(cell, since_ns)) ++tree.moved;
  }
  return trees_;
}

void RecoveryChecker::finish() {
  sizes_.finish(count_trees(), ground_.repaired_ns() + fault_free_ns);
}

}  // namespace robotskin::campaign
