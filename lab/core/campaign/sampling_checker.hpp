// SPDX-License-Identifier: Apache-2.0
// That every cell with a way to the host has an id, samples at its rate and sends what its mode asks for (I11): in
// clock mode one sample of as many as the rate divisor says, in event mode whatever differs from what it sent last, and
// one for freshness after a silence.
//
// What it sends is taken from the sequence of its own samples; that they arrive is the ledger's to say.
#pragma once

#include <cstdint>
#include <vector>

#include "campaign/cable_loads.hpp"
#include "campaign/fault_case.hpp"
#include "campaign/ground_truth.hpp"
#include "campaign/invariants.hpp"
#include "campaign/overruns.hpp"
#include "campaign/recovery_checker.hpp"

namespace robotskin::campaign {

class SamplingChecker {
 public:
  SamplingChecker(const FaultCase& drawn, BreakLog& breaks);

  void cell_stepped(const world::Network& network, const GroundTruth& ground, std::size_t cell, const rs_input& input);
  // Every millisecond. Where processors lose frames of an overload, ticks wait for them as well, by which cells sample.
  void poll(const world::Network& network, const GroundTruth& ground, const RecoveryChecker& recovery,
            const CableLoads& loads, const Overruns& overruns);

 private:
  struct Cell {
    std::int64_t named_ns = -1, sent_ns = -1;
    std::int32_t sent_value = 0;  // of the channel that tells of touch, in the last sample sent
    std::uint32_t dropped = 0;
    std::uint16_t tick = 0;
    std::uint8_t root = 0, divisor = 1, largest = 1;
    std::uint8_t sequence = 0;
    // How often it has begun to count by another time or divisor, since it sent last; then until it sends once more, as
    // its phase changes after that.
    std::int64_t changes = 0;
    bool changed = false;
    bool told = false;
  };

  static void note(Cell& cell, const rs_wave& wave);
  std::int64_t silence_ns(const Cell& cell, std::int32_t hops) const;

  BreakLog& breaks_;
  std::vector<Cell> cells_;
  bool events_;
  bool takes_time_;  // cells' processors do
  std::int64_t period_ns_ = 0;
  std::int32_t threshold_;
};

}  // namespace robotskin::campaign
