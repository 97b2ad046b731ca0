// SPDX-License-Identifier: Apache-2.0
// Whether cells that compute their own torques say what double precision says (I12), and whether the host gets the
// sums.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "campaign/fault_case.hpp"
#include "campaign/ground_truth.hpp"
#include "campaign/invariants.hpp"
#include "campaign/touch_model.hpp"

namespace robotskin::campaign {

// The positions that the host broadcasts at a time: the first names it, chance the others.
std::array<std::int16_t, RS_JOINTS_PER_PART> posture_at(std::uint64_t seed, std::int64_t time_ms);

class TouchChecker {
 public:
  TouchChecker(const FaultCase& drawn, BreakLog& breaks);

  bool in_use() const { return !cells_.empty(); }
  // Gives the cells their parameters, before they start.
  void prepare(world::Network& network) const;
  void cell_stepped(const world::Network& network, const GroundTruth& ground, std::size_t cell, const rs_input& input);
  void datagram(const world::Network& network, std::span<const std::uint8_t> datagram);
  void poll(const world::Network& network, const GroundTruth& ground);

  std::uint64_t judged() const { return judged_; }     // torques of a cell in an epoch
  std::uint64_t sums() const { return sums_judged_; }  // epochs whose sums were

 private:
  struct Cell {
    TouchModel model;
    std::uint32_t epoch = 0;
    bool corrupted = false;    // its memory was, since it last started
    std::uint8_t unit = 0;     // of its tree,
    std::int64_t came_ns = 0;  // and since when
  };
  struct Sum {
    std::int64_t cells = 0, active = 0;
    std::array<std::int64_t, RS_JOINTS_PER_PART> joint{};

    bool operator==(const Sum&) const = default;
  };
  struct Epoch {
    std::int64_t first_ns = -1;
    bool judged = false, excused = false;
    Sum given, told;
  };

  void judge_force(const world::Network& network, std::size_t cell, const rs_sample& sample);
  void judge_torques(const world::Network& network, const GroundTruth& ground, std::size_t cell);
  Epoch& epoch_of(std::uint32_t number, std::int64_t now_ns);

  BreakLog& breaks_;
  std::uint64_t seed_;
  std::vector<Cell> cells_;
  std::array<Epoch, RS_EPOCH_MASK + 1> epochs_;
  std::uint64_t judged_ = 0, sums_judged_ = 0;
};

}  // namespace robotskin::campaign
