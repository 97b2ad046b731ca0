// SPDX-License-Identifier: Apache-2.0
// What the host knows of the network is the real graph, 1.1 s after the last change (I17).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "campaign/ground_truth.hpp"
#include "campaign/invariants.hpp"
#include "campaign/line_losses.hpp"
#include "campaign/overruns.hpp"
#include "campaign/recovery_checker.hpp"

namespace robotskin::campaign {

class TopologyChecker {
 public:
  static constexpr std::int64_t known_ns = 1100 * ms;

  TopologyChecker(std::size_t cells, const world::LineQuality& line, BreakLog& breaks)
      : breaks_(breaks), losses_(line), told_(cells), dropped_(cells) {}

  void datagram(const world::Network& network, std::span<const std::uint8_t> datagram);
  // This frame was lost by a processor that may lose some: if it is a report, its cell may be unknown for a while, also
  // where it hangs in another tree since.
  void crowded_out(std::int64_t now_ns, const std::uint8_t* frame);
  // After each step of a cell. Where more cells hang on a cable than it carries, a full queue may drop reports, which
  // come again a second later.
  void cell_stepped(const world::Network& network, std::size_t cell, const rs_input& input, bool within_load);
  // At the end of a run. Where reports are lost by chance, cells whose last one is too old are counted. Trees whose
  // processors had too much to do are left out.
  void finish(const world::Network& network, const GroundTruth& ground, const RecoveryChecker& recovery,
              const Overruns& overruns);

  std::uint64_t judged() const { return judged_; }  // reports

 private:
  static constexpr std::int64_t never_ns = -10'000 * ms;

  struct Told {
    std::int64_t time_ns = -1;
    rs_topology topology{};
    std::int64_t crowded_out_ns = never_ns;  // when an overtaxed cell last lost a report of this one
  };

  void judge(const world::Network& network, const GroundTruth& ground, std::size_t cell);

  BreakLog& breaks_;
  LineLosses losses_;
  std::vector<Told> told_;              // by cell, its last report
  std::vector<std::uint32_t> dropped_;  // by cell, reports and requests that found its queue full so far
  std::uint64_t judged_ = 0;
};

}  // namespace robotskin::campaign
