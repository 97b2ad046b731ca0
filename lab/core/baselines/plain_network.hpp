// SPDX-License-Identifier: Apache-2.0
// Nodes that only store and forward, on the same queue of events: what the engine itself costs, beside other
// simulators.
//
// Each node makes a frame a period at a phase of its own, and passes frames on to its next node, one at a time, 50 us
// each; queues have no limit but what arrives.
#pragma once

#include <cstdint>
#include <vector>

namespace robotskin::lab {

struct PlainCounts {
  std::uint64_t made = 0, hops = 0, arrived = 0;
  std::uint32_t queue_peak = 0;
  double delay_mean_us = 0;  // from making to arrival
};

// next: (N) the node that each node sends to, -1: the frames have arrived after that hop. Without circles.
// Throws std::invalid_argument for a node that does not exist.
PlainCounts run_plain_network(const std::vector<std::int32_t>& next, std::int64_t period_ns, std::int64_t duration_ns,
                              std::uint64_t seed);

}  // namespace robotskin::lab
