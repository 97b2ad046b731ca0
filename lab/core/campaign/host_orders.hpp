// SPDX-License-Identifier: Apache-2.0
// What the host sends down: colours for all LEDs and joint positions; that no cell shows a colour that it was never
// (I19), and that what it orders reaches every cell with a way (I11).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "campaign/fault_case.hpp"
#include "campaign/ground_truth.hpp"
#include "campaign/invariants.hpp"
#include "campaign/line_losses.hpp"
#include "campaign/recovery_checker.hpp"
#include "campaign/route_checker.hpp"
#include "world/network/network.hpp"

namespace robotskin::campaign {

class HostOrders {
 public:
  HostOrders(const Workload& workload, std::uint64_t seed, const world::LineQuality& line, BreakLog& breaks)
      : breaks_(breaks), in_use_(workload.orders), postures_(workload.touch), seed_(seed), losses_(line) {}

  void send(world::Network& network);  // every millisecond; now and then something goes down
  // Every millisecond. What passes by cells on lines that lose frames without a fault is counted.
  void poll(const world::Network& network, const GroundTruth& ground, const RouteChecker& routes,
            const RecoveryChecker& recovery);
  void finish(const world::Network& network);                                           // at the end
  std::uint32_t orders() const { return static_cast<std::uint32_t>(sent_ns_.size()); }  // so far

 private:
  void note_moves(const world::Network& network, const RouteChecker& routes);

  static constexpr std::int64_t orders_every_ms = 16, joints_every_ms = 4;

  std::uint32_t colour_of(std::uint32_t order) const;

  BreakLog& breaks_;
  bool in_use_, postures_;
  std::uint64_t seed_;
  std::vector<std::int64_t> sent_ns_;             // of order 1, 2, ...
  std::vector<std::uint8_t> told_, parent_port_;  // by cell
  // By cell, bit i: while the i-th newest order was on its way the cell took another parent, and may have missed it.
  std::vector<std::uint32_t> passed_by_;
  // When a cell with a way last had no id, by root; and by cell, of the trees that it has been in.
  std::array<std::int64_t, 256> naming_ns_{};
  std::vector<std::int64_t> naming_beside_ns_;
  std::uint32_t datagrams_ = 0;
  LineLosses losses_;  // cells that missed three orders in turn
};

}  // namespace robotskin::campaign
