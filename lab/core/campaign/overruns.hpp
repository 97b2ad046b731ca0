// SPDX-License-Identifier: Apache-2.0
// Frames that found a cell too busy to take them, and where that may be.
//
// A processor is made for the cells of one cable at 250 Hz. It may lose frames where more hang on the cable, where the
// tree is too deep for its torque sums to be added up in time and they do go up one by one, while it catches up with
// what a repair costs, and while cells move from tree to tree. Nowhere else is a frame that is lost so any excuse.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "campaign/cable_loads.hpp"
#include "campaign/ground_truth.hpp"
#include "campaign/processing_times.hpp"

namespace robotskin::campaign {

class Overruns {
 public:
  // `limbs`: of whose torques there are sums.
  Overruns(ProcessingTimes times, std::int32_t limbs) : times_(times), limbs_(limbs) {
    overloaded_ns_.fill(never_ns);
    overtaxed_ns_.fill(never_ns);
  }

  // Every few milliseconds. `late_sums`: lately, of each root, how many sums of an epoch came beyond those of a tree
  // that adds them up.
  void weigh(std::int64_t now_ns, const CableLoads& loads, std::span<const std::uint32_t> late_sums);
  // A frame found no room in that cell. Whether that may be.
  bool lost(const world::Network& network, const GroundTruth& ground, std::size_t cell);

  // When a processor last lost a frame in that root's tree while it had more cells, or was deeper, than it bears.
  std::int64_t overtaxed_ns(std::uint8_t root) const { return overtaxed_ns_[root]; }

 private:
  static constexpr std::int64_t never_ns = -10'000 * ms;

  ProcessingTimes times_;
  std::int32_t limbs_;
  std::array<std::int64_t, 256> overloaded_ns_, overtaxed_ns_;  // by root
};

}  // namespace robotskin::campaign
