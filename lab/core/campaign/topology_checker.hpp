// SPDX-License-Identifier: Apache-2.0
// What the host knows of the network is the real graph, 1.1 s after the last change (I17).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "campaign/ground_truth.hpp"
#include "campaign/invariants.hpp"
#include "campaign/overruns.hpp"
#include "campaign/recovery_checker.hpp"

namespace robotskin::campaign {

class TopologyChecker {
 public:
  static constexpr std::int64_t known_ns = 1100 * ms;

  TopologyChecker(std::size_t cells, BreakLog& breaks) : breaks_(breaks), told_(cells) {}

  void datagram(const world::Network& network, std::span<const std::uint8_t> datagram);
  // At the end of a run in which no report was lost by chance; by a processor that had too much to do, only in trees
  // that are left out.
  void finish(const world::Network& network, const GroundTruth& ground, const RecoveryChecker& recovery,
              const Overruns& overruns);

  std::uint64_t judged() const { return judged_; }  // reports

 private:
  struct Told {
    std::int64_t time_ns = -1;
    rs_topology topology{};
  };

  void judge(const world::Network& network, const GroundTruth& ground, std::size_t cell);

  BreakLog& breaks_;
  std::vector<Told> told_;  // by cell, its last report
  std::uint64_t judged_ = 0;
};

}  // namespace robotskin::campaign
