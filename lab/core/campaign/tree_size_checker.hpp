// SPDX-License-Identifier: Apache-2.0
// What section units say of the size of the tree at each of their ports (I9): looked at once a millisecond while the
// skin is whole and at rest.
//
// A move takes cells from one tree to another at once, and the word of it goes up hop by hop. So a size may be that of
// a moment ago. A branch that moves within a tree counts twice or not at all until both words of it are through; deep
// trees that drain a branch may move others before that. Neither load nor a processor that
// loses frames excuses more: levelling and the rate divisor go by these sizes, and most of all in a tree that is too
// full.
#pragma once

#include <cstdint>
#include <vector>

#include "campaign/ground_truth.hpp"
#include "campaign/invariants.hpp"

namespace robotskin::campaign {

class TreeSizeChecker {
 public:
  // A port of a section unit counts as unit * RS_SECTION_UNIT_PORTS_MAX + port, both from 0.
  struct Tree {
    std::uint32_t cells = 0;
    std::int32_t deepest = 0;  // hops
    std::uint32_t moved = 0;   // cells that have another way within the tree since less than word_ns(deepest)
  };

  TreeSizeChecker(const world::Network& network, BreakLog& breaks, bool clean_lines);

  // How long the word of a change takes from so deep a cell.
  std::int64_t word_ns(std::int32_t hops) const;
  // The true trees now, by port.
  void weigh(const std::vector<Tree>& trees);
  // At the end of the run: the true trees, and since when sizes have had time to become true.
  void finish(const std::vector<Tree>& trees, std::int64_t since_ns) const;

 private:
  static constexpr std::int64_t recent_ns = 24 * ms;  // a moment ago
  static constexpr std::size_t recent_count = recent_ns / ms;

  struct Port {
    std::vector<std::uint32_t> recent;  // true sizes of the last weighings, a ring
    std::int64_t right_ns = -1;         // when the size that is told was last right to the cell
    std::int64_t true_lately_ns = 0;    // when it was last one that the tree has had lately
    bool told = false;                  // that it is not: once is enough
  };

  // What a section unit says of the tree at its port; 0: there is none.
  std::uint32_t told_size(std::size_t at) const;
  void add_break(std::size_t at, std::uint32_t cells) const;

  const world::Network& network_;
  BreakLog& breaks_;
  bool clean_lines_;
  std::int64_t weighed_ns_ = -1;
  std::vector<Port> ports_;
};

}  // namespace robotskin::campaign
