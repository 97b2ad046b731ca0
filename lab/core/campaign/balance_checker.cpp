// SPDX-License-Identifier: Apache-2.0
#include "campaign/balance_checker.hpp"

#include <algorithm>

namespace robotskin::campaign {

void BalanceChecker::granted(const world::Network& network, const RouteChecker& routes, const std::uint8_t* frame) {
  rs_grant grant;
  rs_grant_unpack(&grant, frame);
  if (grant.cell == RS_ID_NONE) return;
  // All whose way leads through the cell: more than that cannot move with it.
  std::uint32_t below = 0;
  for (std::size_t cell = 0; cell < network.cell_count(); ++cell) {
    auto at = static_cast<std::int32_t>(cell);
    for (std::size_t hops = 0; at >= 0 && hops < network.cell_count(); ++hops) {
      if (network.cell(static_cast<std::size_t>(at)).id == grant.cell) {
        ++below;
        break;
      }
      at = routes.parent(static_cast<std::size_t>(at));
    }
  }
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

void BalanceChecker::finish(std::int64_t now_ns) {
  if (since_ns_ < 0 || now_ns - since_ns_ < 100 * ms || squares_ <= squares_before_) return;
  breaks_.add(Invariant::levelling_progress, now_ns, {},
              {{"sum of squares", static_cast<std::int64_t>(squares_)},
               {"before", static_cast<std::int64_t>(squares_before_)},
               {"ms ago", (now_ns - since_ns_) / ms}});
}

}  // namespace robotskin::campaign
