// SPDX-License-Identifier: Apache-2.0
#include "campaign/tree_size_checker.hpp"

#include <algorithm>

#include "robotskin/section_unit.h"
#include "robotskin/timing.h"

namespace robotskin::campaign {

TreeSizeChecker::TreeSizeChecker(const world::Network& network, BreakLog& breaks, bool clean_lines)
    : network_(network),
      breaks_(breaks),
      clean_lines_(clean_lines),
      ports_(RS_SECTION_UNIT_PORTS_MAX * network.unit_count()) {}

std::uint32_t TreeSizeChecker::told_size(std::size_t at) const {
  const std::size_t unit = at / RS_SECTION_UNIT_PORTS_MAX;
  const auto& port = network_.unit(unit).port[at % RS_SECTION_UNIT_PORTS_MAX];
  return network_.unit_runs(unit) && port.root ? port.size : 0;
}

// Each cell on the way may have told so much lately that it waits for the mean time between two; and what is lost, on a
// line or for want of a processor's time, is told again after the longest time between two.
std::int64_t TreeSizeChecker::word_ns(std::int32_t hops) const {
  const std::int64_t told_again = clean_lines_ ? 2 : 6;
  return us * (told_again * RS_STATUS_US + hops * std::int64_t{RS_STATUS_MEAN_US});
}

void TreeSizeChecker::add_break(std::size_t at, std::uint32_t cells) const {
  breaks_.add(Invariant::tree_sizes, network_.time_ns(), {},
              {{"unit", static_cast<std::int64_t>(at / RS_SECTION_UNIT_PORTS_MAX)},
               {"port", static_cast<std::int64_t>(at % RS_SECTION_UNIT_PORTS_MAX + 1)},
               {"size", told_size(at)},
               {"cells", cells}});
}

void TreeSizeChecker::weigh(const std::vector<Tree>& trees) {
  const std::int64_t now_ns = network_.time_ns();
  const bool at_rest = now_ns - weighed_ns_ <= ms;
  weighed_ns_ = now_ns;
  for (std::size_t at = 0; at < ports_.size(); ++at) {
    Port& port = ports_[at];
    if (!at_rest) {
      port.recent.clear();
      port.true_lately_ns = now_ns;
      port.told = false;
    }
    if (port.recent.size() == recent_count) port.recent.erase(port.recent.begin());
    port.recent.push_back(trees[at].cells);
    const auto [least, most] = std::ranges::minmax(port.recent);
    const std::uint32_t size = told_size(at);
    if (size == trees[at].cells) port.right_ns = now_ns;
    if (size + trees[at].moved >= least && size <= most + trees[at].moved) port.true_lately_ns = now_ns;
    if (port.told || now_ns - port.true_lately_ns <= word_ns(trees[at].deepest)) continue;
    port.told = true;
    add_break(at, trees[at].cells);
  }
}

void TreeSizeChecker::finish(const std::vector<Tree>& trees, std::int64_t since_ns) const {
  const std::int64_t lately_ns = network_.time_ns() - 100 * ms;
  if (since_ns > lately_ns) return;
  for (std::size_t at = 0; at < ports_.size(); ++at)
    if (ports_[at].right_ns < lately_ns && !ports_[at].told) add_break(at, trees[at].cells);
}

}  // namespace robotskin::campaign
