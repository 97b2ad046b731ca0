// SPDX-License-Identifier: Apache-2.0
// How long samples wait in a cell, that queues stay within their size (I13), and that none overflows once the rate
// divisor has had its time (I18).
//
// Over lines that spoil frames samples are repeated, which may fill queues; and while trees form, so may torque sums of
// single cells, which go first. From the first repeated sample in a queue, or if trees formed in the two epochs
// before it filled, until it is empty, no cell is held to how long others wait there, nor to those that find it full.
// While cells move from tree to tree, beacons are held back, each new one asks for much of a processor's time, and some
// cells are counted in both trees: what waited comes at once, and may find a queue that holds less.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "campaign/ground_truth.hpp"
#include "campaign/invariants.hpp"
#include "campaign/overruns.hpp"
#include "campaign/recovery_checker.hpp"
#include "campaign/sample_ledger.hpp"

namespace robotskin::campaign {

class QueueChecker {
 public:
  static constexpr std::int64_t waiting_max_ns = 8 * ms;

  QueueChecker(std::size_t cells, bool events, BreakLog& breaks) : breaks_(breaks), cells_(cells), events_(events) {}

  // Cells of a port at divisor 1: more than `bearable` need a larger one; up to `draining`, full queues become empty,
  // with `sums` torque sums an epoch.
  struct PortLoad {
    std::uint32_t bearable, draining, sums;
    std::int64_t known_hop_ns;  // that a change of size takes up, and a divisor down
  };

  // A torque sum goes to the section unit.
  void sum_sent(std::uint8_t root) { ++sums_[root].sent; }
  void end_epoch() {
    for (Sums& sums : sums_) sums.end_epoch();
  }
  // Lately in an epoch, beyond those of a tree that adds them up.
  std::uint32_t late_sums(std::size_t root, PortLoad port) const {
    return std::max(sums_[root].in_epoch(), port.sums) - port.sums;
  }

  // Once an epoch. Events are what no divisor thins out; nor does one give back to a processor that has lost frames the
  // time for torque sums, which come late then, and fill lines one by one. In deep trees, too, sums come too late to be
  // added up, and each that goes up alone takes the place of a cell's samples. A section unit knows of them: they may
  // leave a line no time to empty queues, but not be more than it carries.
  void count_drops(const world::Network& network, const GroundTruth& ground, const RouteChecker& routes,
                   const RecoveryChecker& recovery, const Overruns& overruns, const CableLoads& loads,
                   std::span<const std::uint32_t> late_sums, PortLoad port, bool undisturbed);

  // `within_load`: the cell's tree has no more cells than its cable can carry. The sample that the cell has just lost
  // to repeated ones.
  std::optional<TakenSample> cell_stepped(const world::Network& network, const GroundTruth& ground,
                                          const RecoveryChecker& recovery, std::size_t cell, const rs_input& input,
                                          bool within_load);

  std::int64_t longest_ns() const { return longest_ns_; }

 private:
  // When what stands at each place of the ring came in.
  struct Cell {
    std::array<std::int64_t, RS_QUEUE_DATA> since_ns{};
    std::uint8_t first = 0, count = 0;
    std::uint8_t most = RS_QUEUE_DATA;  // that may wait before samples are left out
    std::uint32_t dropped = 0, dropped_in_all = 0, divisor = 1;
    std::int64_t eased_ns = 0;  // when the divisor rose last, or sums left no time to empty queues
    std::int64_t begun_ns = 0;  // when it was empty last
    bool crowded = false;       // since then a repeated sample has been in it, or trees have formed
    std::uint32_t crowded_out = 0;
    TakenSample oldest;  // while it is full
  };

  struct Sums {
    static constexpr std::uint32_t epochs = 16;  // 64 ms: what was sent fades in so long
    std::uint32_t sent = 0, lately = 0;          // in this epoch, and on the average `epochs` times as many

    void end_epoch() { lately += std::exchange(sent, 0) - lately / epochs; }
    std::uint32_t in_epoch() const { return lately / epochs; }
  };

  BreakLog& breaks_;
  std::vector<Cell> cells_;
  std::array<Sums, 256> sums_;  // by root
  bool events_;
  std::int64_t longest_ns_ = 0, counted_ns_ = 0;
};

}  // namespace robotskin::campaign
