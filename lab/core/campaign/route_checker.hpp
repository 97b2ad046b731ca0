// SPDX-License-Identifier: Apache-2.0
// Parents at every event: no circle, distances in order, and nothing adopted that was not said (I1 to I5, I19).
//
// A pointer is what a cell believes: it leads to the one whose beacon it adopted last, until it lets go or adopts
// another, whatever has become of the wire meanwhile. A check costs a comparison while nothing changes; a new pointer
// is walked up to its root, and a new distance is compared with those of the neighbours only.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "campaign/beacon_log.hpp"
#include "campaign/ground_truth.hpp"
#include "campaign/invariants.hpp"

namespace robotskin::campaign {

class RouteChecker {
 public:
  static constexpr std::int32_t none = -1, unit = -2;  // instead of a parent cell

  RouteChecker(const world::Network& network, GroundTruth& ground, BeaconLog& beacons, BreakLog& breaks);

  // `taken_ns`: of a frame whose hops are used up, when its sample was taken, if that is known.
  void cell_stepped(std::size_t cell, const rs_input& input, std::optional<std::int64_t> taken_ns);
  // Whole, by a cell, to whose board it came at that time; before its step is judged.
  void frame_taken(std::size_t at_wire, const std::uint8_t* frame, std::int64_t came_ns);
  void settle();     // after a fault: a cell that is off points nowhere
  void check_all();  // when memory is lawful again

  std::int32_t parent(std::size_t cell) const { return shadow_[cell].parent; }
  unsigned parent_port(std::size_t cell) const { return shadow_[cell].port; }
  unsigned hops(std::size_t cell) const { return shadow_[cell].hops; }
  // Whether `found(cell)` holds of the cell, or of one that its way leads over.
  template <typename Found>
  bool any_on_way(std::size_t cell, const Found& found) const {
    auto at = static_cast<std::int32_t>(cell);
    for (std::size_t hops = 0; at >= 0 && hops < shadow_.size(); ++hops, at = parent(static_cast<std::size_t>(at)))
      if (found(static_cast<std::size_t>(at))) return true;
    return false;
  }
  std::int64_t changed_ns() const { return changed_ns_; }  // the last time that any cell had another parent
  // Without a parent for so long that it has forgotten how near it was, or since its boot: it cannot know the time. Nor
  // can one that took a time played again, until it hears the true one.
  bool cannot_know_time(std::size_t cell) const;
  void frame_planted(std::size_t at_wire, const std::uint8_t* frame);  // played again
  std::uint64_t adoptions() const { return adoptions_; }

 private:
  struct Shadow {
    rs_wave wave{};
    std::int64_t advanced_ns = 0;
    std::int64_t boot_of_parent_ns = 0;  // the boot of the parent whose beacon was adopted
    std::int64_t alone_ns = -1000 * ms;  // since when it has no parent, if it has none
    std::int32_t parent = none;
    std::uint16_t feasible_sequence = 0;
    std::uint8_t feasible_hops = RS_HOPS_POISON, hops = RS_HOPS_POISON, port = 0;
    bool unbound = true;
    bool misled = false;                 // its wave was played again
    std::int64_t false_ns = -1000 * ms;  // when it had a wave that no section unit made
    std::uint32_t hops_exhausted = 0;
  };

  void adopted(std::size_t cell, const rs_route& route);
  void check_circle(std::size_t cell);
  void check_order(std::size_t child);
  void check_children(std::size_t cell);
  void copy(std::size_t cell);

  const world::Network& network_;
  GroundTruth& ground_;
  BeaconLog& beacons_;
  BreakLog& breaks_;
  std::vector<Shadow> shadow_;
  bool tick_planted_ = false;  // the next tick that a cell takes; no neighbour has said it now
  std::int64_t changed_ns_ = 0;
  std::uint64_t adoptions_ = 0;
};

}  // namespace robotskin::campaign
