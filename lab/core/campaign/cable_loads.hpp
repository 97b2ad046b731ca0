// SPDX-License-Identifier: Apache-2.0
// The true loads of the cables, by paths and by what cells send, and which cells an overload concerns.
//
// A tree is overloaded while more cells hang on its cable than that carries, torque sums that come late and one by one
// counted like samples, or while its cells send more events than that. An overload excuses the cells of its own tree
// alone, and those that were in it until lately.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "campaign/ground_truth.hpp"
#include "world/network/network.hpp"

namespace robotskin::campaign {

class CableLoads {
 public:
  // What came in under an overload is out again by then.
  static constexpr std::int64_t drained_ns = 80 * ms;
  static constexpr std::int64_t weighed_every_ns = 4 * ms;  // a period of the default rate
  static constexpr std::size_t roots = 256;

  // `cells_carried`: by a cable, at the default rate. `by_sent`: cells may send more often than that.
  CableLoads(std::size_t cells, std::uint32_t cells_carried, bool by_sent)
      : cells_carried_(cells_carried), by_sent_(by_sent), overloaded_cell_ns_(cells, never_ns) {
    overloaded_root_ns_.fill(never_ns);
    overloaded_unit_ns_.fill(never_ns);
  }

  // A cell of that root has sent a sample of its own.
  void sent(std::uint8_t root) { ++sent_[root]; }
  // `late_sums`: by root, torque sums of the last epoch that came one by one, beyond what all trees send.
  void weigh(const world::Network& network, const GroundTruth& ground, std::span<const std::uint32_t> late_sums);

  std::span<const std::uint32_t> cells() const { return cells_; }           // by root
  std::span<const std::int32_t> deepest() const { return deepest_; }        // hops, by root
  std::span<const std::uint8_t> overloaded() const { return overloaded_; }  // at the last weighing, by root
  // When the cell's tree was last overloaded, as far as its samples may have met that.
  std::int64_t overloaded_ns(std::size_t cell) const { return overloaded_cell_ns_[cell]; }
  // Nothing that was queued under overload is left where the cell's samples go.
  bool within(std::size_t cell, std::int64_t now_ns) const { return now_ns - overloaded_ns(cell) > drained_ns; }
  // The same of all trees of the cell's section unit, which hands over a sum once as many cells are in it as the last
  // time: of trees that lose cells to an overload and get them back, that number says nothing.
  bool unit_within(std::uint8_t root, std::int64_t now_ns) const {
    return now_ns - overloaded_unit_ns_[unit_of(root)] > drained_ns;
  }
  // What was queued under overload may be left somewhere.
  bool any_overloaded(std::int64_t now_ns) const {
    return std::ranges::any_of(overloaded_root_ns_, [&](std::int64_t at_ns) { return now_ns - at_ns <= drained_ns; });
  }
  // Samples so far that cells sent beyond what their cables carry, torque sums that came one by one counted in.
  std::uint64_t excess() const { return excess_; }

 private:
  static constexpr std::int64_t never_ns = -10'000 * ms;
  // Events of one millisecond come at once: torque sums and reports find gaps where a share is left to them.
  static constexpr double bursts_carried = 7.0 / 8;
  static constexpr std::size_t units = 16;

  static std::size_t unit_of(std::size_t root) { return root / units; }  // as the firmware numbers them

  std::uint32_t cells_carried_;
  bool by_sent_;
  std::array<std::uint32_t, roots> sent_{}, cells_{};
  std::array<std::int32_t, roots> deepest_{};
  std::array<std::uint8_t, roots> overloaded_{};
  std::array<std::int64_t, roots> overloaded_root_ns_;
  std::array<std::int64_t, units> overloaded_unit_ns_;
  std::vector<std::int64_t> overloaded_cell_ns_;
  std::uint64_t excess_ = 0;
};

}  // namespace robotskin::campaign
