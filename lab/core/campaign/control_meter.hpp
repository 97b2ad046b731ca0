// SPDX-License-Identifier: Apache-2.0
// How much of each wire goes to the network's own needs (I14).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "campaign/ground_truth.hpp"
#include "campaign/invariants.hpp"

namespace robotskin::campaign {

class ControlMeter {
 public:
  static constexpr std::size_t beacons_per_ms = 4;
  // Of a clock 2 % fast; and the first may have had to wait for the frames that the board held while the last had not.
  static constexpr std::int64_t beacon_window_ns = ms * 98 / 100 - RS_FRAMES_OUT * RS_FRAME_US * us;
  static constexpr std::int64_t window_ns = 100 * ms;
  // In 100 ms at most: beacons one a millisecond of a clock that is 2 % fast, 5.1 %; status frames up, 24 in a burst
  // and one each 3.3 ms, 2.7 %, or grants down, one each 2 ms, 2.5 %.
  static constexpr double share_max = 0.08;

  ControlMeter(std::size_t wires, BreakLog& breaks) : breaks_(breaks), wires_(wires) {}

  void frame_sent(const GroundTruth& ground, std::size_t wire, const std::uint8_t* frame, std::int64_t now_ns);
  void poll(const GroundTruth& ground, std::int64_t now_ns);

  double largest_share() const { return largest_share_; }

 private:
  struct Wire {
    std::array<std::int64_t, beacons_per_ms + 1> beacon_ns{};
    std::uint8_t next = 0;
    std::uint32_t control = 0, beacons = 0;  // frames in the window
  };

  BreakLog& breaks_;
  std::vector<Wire> wires_;
  std::int64_t window_start_ns_ = 0;
  double largest_share_ = 0;
};

}  // namespace robotskin::campaign
