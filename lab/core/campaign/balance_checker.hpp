// SPDX-License-Identifier: Apache-2.0
// Levelling never makes it worse (I10): no port becomes fuller than the fullest was, but by what was granted to it over
// the mean; and when it is done, loads are no less even than before. Nor does it rest while a leaf could go to a tree
// that is smaller by two.
//
// Loads are counted from the cells, and what a grant moves from their parents; of the section units' reckoning only the
// grants are heard. Several moves to a tree may be under way at once, so that what was granted to it is summed.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "campaign/ground_truth.hpp"
#include "campaign/invariants.hpp"
#include "campaign/recovery_checker.hpp"
#include "campaign/route_checker.hpp"

namespace robotskin::campaign {

class BalanceChecker {
 public:
  explicit BalanceChecker(BreakLog& breaks) : breaks_(breaks) {}

  void granted(const world::Network& network, const RouteChecker& routes, const std::uint8_t* frame);
  // `loads`: cells by root. `undisturbed`: whole, calm and repaired.
  void weigh(std::int64_t now_ns, std::span<const std::uint32_t> loads, bool undisturbed);
  // What could still be made more even.
  void weigh_chances(const world::Network& network, const GroundTruth& ground, const RouteChecker& routes,
                     const RecoveryChecker& recovery, bool undisturbed);
  void finish(std::int64_t now_ns);

  std::uint64_t grants() const { return grants_; }

 private:
  // From the grant to the last of the subtree's arrival: down the tree, a hold, and the subtree's next ticks.
  static constexpr std::int64_t under_way_ns = 60 * ms;
  // A leaf that has moved rests for 64 ticks, and a round takes as many at most; two rounds in a row may find no offer
  // that fits: 256 ticks. More than that without a grant would need more such rounds, or each to lose its frames. What
  // offers and grants take on their way is added, and chosen.
  static constexpr std::int64_t grant_within_ns = 300 * ms;

  struct Grant {
    std::int64_t time_ns = -under_way_ns;
    std::uint8_t target = 0;
    std::uint32_t cells = 0;
  };

  // A port of that cell behind which is a smaller tree of the same section unit, if the cell may go there; 0: none.
  unsigned port_to_smaller(const world::Network& network, const GroundTruth& ground,
                           std::span<const std::uint32_t> loads, std::size_t cell) const;

  BreakLog& breaks_;
  std::array<Grant, 64> recent_;
  std::uint64_t grants_ = 0;
  std::uint32_t cells_ = 0, fullest_ = 0;
  std::uint64_t squares_before_ = 0, squares_ = 0;
  std::int64_t since_ns_ = -1;  // undisturbed, with as many cells
  std::int64_t idle_ns_ = -1;   // undisturbed since then, with a leaf that could move, and without a grant
  std::uint64_t grants_then_ = 0;
};

}  // namespace robotskin::campaign
