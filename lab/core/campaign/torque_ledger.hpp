// SPDX-License-Identifier: Apache-2.0
// Every epoch's torque sums at the host: each cell in them once, all of them counted, and without faults none missing
// (I12).
//
// Each cell adds one bit that no other cell of its limb has. A sum of different bits has as many ones as addends; where
// two are equal they make a carry, and the sum has fewer. So a sum tells which are in it, and that none is in it twice.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "campaign/cable_loads.hpp"
#include "campaign/fault_case.hpp"
#include "campaign/ground_truth.hpp"
#include "campaign/invariants.hpp"
#include "campaign/line_losses.hpp"
#include "campaign/recovery_checker.hpp"
#include "campaign/route_checker.hpp"

namespace robotskin::campaign {

// What a cell adds in every epoch.
rs_contribution contribution_of(std::size_t cell, std::size_t cells, std::int32_t limbs);

class TorqueLedger {
 public:
  // A damaged cell may spoil the sum of each limb in the epochs of 60 ms, and one more while they come to the host.
  static constexpr std::uint64_t excused_max = 64;

  TorqueLedger(std::size_t cells, std::int32_t limbs, ProcessingTimes times, const world::LineQuality& line,
               BreakLog& breaks);

  bool in_use() const { return limbs_ > 0; }
  void datagram(const world::Network& network, const GroundTruth& ground, std::span<const std::uint8_t> datagram);
  // Every millisecond. What is missing where frames are lost by chance is counted.
  void poll(const world::Network& network, const GroundTruth& ground, const RouteChecker& routes,
            const RecoveryChecker& recovery, const CableLoads& loads);
  void finish(std::int64_t now_ns);  // at the end

  std::uint64_t sums() const { return sums_; }
  std::uint64_t excused() const { return excused_; }              // sums that were false, as memory had been damaged
  std::uint64_t epochs_judged() const { return epochs_judged_; }  // for being complete

 private:
  // The cells heard of in the epoch of this number on the wire.
  struct Epoch {
    std::int64_t first_ns = -1;
    bool judged = true;
    std::vector<std::uint8_t> heard;  // by cell
  };

  void add(const world::Network& network, const GroundTruth& ground, const rs_torque& torque);
  void judge(const world::Network& network, const GroundTruth& ground, const RouteChecker& routes,
             const RecoveryChecker& recovery, const CableLoads& loads, Epoch& epoch);
  void excuse(std::int64_t now_ns, const GroundTruth& ground);
  void keep_time(const world::Network& network);

  BreakLog& breaks_;
  std::size_t cells_;
  std::int32_t limbs_;
  ProcessingTimes times_;
  LineLosses losses_;  // cells in no sum
  std::array<Epoch, RS_EPOCH_MASK + 1> epochs_;
  std::vector<std::uint64_t> unit_time_;
  std::int64_t forming_ns_ = -1000 * ms;  // when trees last formed, which have no sums
  std::int64_t leapt_ns_ = -1000 * ms, polled_ns_ = 0;
  std::uint64_t sums_ = 0, epochs_judged_ = 0, excused_ = 0;
};

}  // namespace robotskin::campaign
