// SPDX-License-Identifier: Apache-2.0
// How much of each wire goes to the network's own needs (I14).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "campaign/ground_truth.hpp"
#include "campaign/invariants.hpp"
#include "campaign/overruns.hpp"

namespace robotskin::campaign {

class ControlMeter {
 public:
  static constexpr std::size_t beacons_per_ms = 4;
  static constexpr std::int64_t window_ns = 100 * ms;
  // In 100 ms at most: beacons one a millisecond of a clock that is 2 % fast, 5.1 %; status frames up, 24 in a burst
  // and one each 3.3 ms, 2.7 %, or grants down, one each 2 ms, 2.5 %. Where a processor has lost
  // frames because too many cells hang on a cable, the beacons that ask for them again come on top: four a millisecond
  // are the bound there.
  static constexpr double share_max = 0.08;

  ControlMeter(std::size_t cells, std::size_t wires, const world::LineQuality& line, ProcessingTimes times,
               BreakLog& breaks)
      : breaks_(breaks),
        wires_(wires),
        overtaxed_ns_(cells, never_ns),
        beacon_window_ns_(beacon_window_ns(line, times)),
        held_ns_(times.longest_ns > 0 ? RS_FRAMES_OUT * slow_frame_ns : 0) {}

  void frame_sent(const GroundTruth& ground, std::size_t wire, const std::uint8_t* frame, std::int64_t now_ns);
  void poll(const world::Network& network, const GroundTruth& ground, const Overruns& overruns);

  double largest_share() const { return largest_share_; }

 private:
  struct Wire {
    std::array<std::int64_t, beacons_per_ms + 1> beacon_ns{};
    std::uint8_t next = 0;
    std::uint32_t control = 0, beacons = 0;  // frames in the window
  };

  // Five beacons take longer. Of a clock 2 % fast; and the first may have had to wait for the frames that the board
  // held or for the processor to end the step, while the last had not.
  static std::int64_t beacon_window_ns(const world::LineQuality& line, ProcessingTimes times) {
    const auto frame_ns = static_cast<std::int64_t>((RS_FRAME_US + line.jitter_us) * 1e3);
    return ms * 98 / 100 - std::max(RS_FRAMES_OUT * frame_ns, times.longest_ns);
  }

  // A slow cell's frames come up to a millisecond later each; what its board held goes out close together in the end.
  static constexpr std::int64_t slow_frame_ns = ms + RS_FRAME_US * us;

  static constexpr std::int64_t never_ns = -10'000 * ms;

  BreakLog& breaks_;
  std::vector<Wire> wires_;
  std::vector<std::int64_t> overtaxed_ns_;  // by cell: when a tree that it hung in was last overtaxed
  std::int64_t beacon_window_ns_, held_ns_;
  std::int64_t window_start_ns_ = 0;
  double largest_share_ = 0;
};

}  // namespace robotskin::campaign
