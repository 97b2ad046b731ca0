// SPDX-License-Identifier: Apache-2.0
// Whole in bounded time: what can be reached is reached, as fast as the distance allows, and as near as the graph
// allows (I6 to I9, I15, I16). Looks once a millisecond.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "campaign/ground_truth.hpp"
#include "campaign/invariants.hpp"
#include "campaign/route_checker.hpp"
#include "campaign/tree_size_checker.hpp"

namespace robotskin::campaign {

class RecoveryChecker {
 public:
  RecoveryChecker(const world::Network& network, GroundTruth& ground, RouteChecker& routes, BreakLog& breaks,
                  bool clean_lines);

  // After a fault: how far its repair has to travel, and whether through cables that carry more than they can.
  void struck(bool everywhere, bool overloaded);
  void poll();    // every millisecond
  void finish();  // at the end of the run

  // Every cell that can be reached has had its path since then; a time yet to come: not now.
  std::int64_t whole_since_ns() const { return whole_since_ns_; }
  // Of all faults so far, from the last disturbance to the moment when all paths were whole, at most.
  std::int64_t longest_repair_ns() const { return longest_repair_ns_; }
  bool has_path(std::size_t cell) const { return path_[cell] == Path::whole; }
  // The same of one cell, which may have been out of reach while all others had theirs.
  std::int64_t path_since_ns(std::size_t cell) const { return path_since_ns_[cell]; }
  std::uint64_t cells_attached() const { return attached_; }
  // What may be false of that cell because memory was overwritten: it is near, or its way has led through there, or it
  // has had none since. All other cells keep the laws of single cells.
  bool calm(std::size_t cell, std::int64_t now_ns) const {
    return affected(cell) ? ground_.calm(now_ns) && !ground_.lawless(now_ns) : ground_.calm_elsewhere(now_ns);
  }
  std::int64_t repaired_ns(std::size_t cell) const {
    return affected(cell) ? std::max(ground_.repaired_ns(), ground_.lawless_until_ns())
                          : std::max(ground_.repaired_elsewhere_ns(), affected_until_ns_[cell] + affected_after_ns_);
  }

 private:
  enum class Path : std::uint8_t { unknown, whole, broken };

  Path path_of(std::size_t cell);
  void follow_paths();
  void spread_damage();
  bool leads_through_damage(std::size_t cell) const;
  bool affected(std::size_t cell) const {
    return affected_until_ns_[cell] > 0 && affected_until_ns_[cell] == ground_.lawless_until_ns();
  }
  void check_elsewhere();
  void check_formation();
  bool stays_away(const rs_route& route, unsigned port) const;
  unsigned nearer_port(std::size_t cell) const;
  void check_nearest();
  const std::vector<TreeSizeChecker::Tree>& count_trees();
  void note_moves();
  bool moved_within_tree(std::size_t cell, std::int64_t since_ns) const;

  const world::Network& network_;
  GroundTruth& ground_;
  RouteChecker& routes_;
  BreakLog& breaks_;
  bool clean_lines_;
  std::vector<Path> path_;
  std::vector<std::size_t> at_port_;  // by cell with a path, the port of a section unit that it leads to
  struct Way {
    std::int32_t parent = RouteChecker::none;
    std::size_t at_port = 0;
    std::int64_t moved_ns = -1000 * ms;  // when the cell took another parent in the same tree
  };
  std::vector<Way> ways_;
  std::vector<TreeSizeChecker::Tree> trees_;
  TreeSizeChecker sizes_;
  std::vector<std::int64_t> path_since_ns_, nearer_since_ns_;
  std::vector<std::int64_t> affected_until_ns_;  // by cell, the end of the damage that it has to do with
  std::int64_t affected_after_ns_;               // and how much longer its repair takes
  std::vector<std::int32_t> trail_;
  std::int64_t whole_since_ns_ = 0, longest_repair_ns_ = 0;
  std::uint64_t attached_ = 0;
  bool was_lawless_ = false, formation_checked_ = false, struck_ = false, repairing_ = true, told_ = false,
       told_elsewhere_ = false;
};

}  // namespace robotskin::campaign
