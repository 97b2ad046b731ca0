// SPDX-License-Identifier: Apache-2.0
// What the channels of every cell did during a window of time, in a few numbers a channel: the evidence from which the
// health of cells is judged.
//
// in   a skin state a tick, the forces as they were measured, and what accelerometers should feel
// out  (N) rows of a window: means, noise, extremes, how long a channel has not changed
// bad  values of a cell that is not alive are not counted; its silence is
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "health/link_motion.hpp"
#include "skin/skin_model.hpp"
#include "skin/skin_state.hpp"

namespace robotskin::health {

// Channels in the order of rs_channel, in SI units: forces as they were measured, before any zero is taken.
inline constexpr std::size_t channel_count = RS_CHANNEL_COUNT;
using Channels = std::array<float, channel_count>;

struct CellWindow {
  std::uint32_t samples = 0;  // new ones
  std::uint32_t silent = 0;   // ticks at which the cell was not alive, other than stuck
  std::uint32_t stuck = 0;    // ticks at which its reader called it stuck
  Channels mean{}, least{}, most{};
  Channels noise{};                 // standard deviation of the noise, from second differences of samples
  Channels at_end{};                // share of the samples at the end of a channel's range
  std::array<float, 3> expected{};  // m/s^2, mean of what its accelerometer should have felt
  std::array<std::uint32_t, channel_count> unchanged{};  // samples since the channel changed last, over all windows
  Channels unchanged_s{};                                // seconds of them
};

class CellWindows {
 public:
  explicit CellWindows(const skin::SkinModel& skin);

  std::size_t size() const noexcept { return rows_.size(); }

  // Once a tick, after the skin was read at `now_ns`. `measured_force` (N, 3) newton before any zero is taken, or
  // empty: those of the state. `motion` of the model's links, or null: not known. No allocation. The state has N cells.
  void add(const skin::SkinState& state, std::span<const std::array<float, 3>> measured_force, const LinkMotion* motion,
           std::int64_t now_ns) noexcept;

  std::uint32_t ticks() const noexcept { return ticks_; }
  std::int64_t begun_ns() const noexcept { return begun_ns_; }
  std::int64_t newest_ns() const noexcept { return newest_ns_; }

  // Ends the window: its rows, valid until the next call; the next one begins.
  std::span<const CellWindow> take();

 private:
  struct Running {
    std::int64_t stamp_ns = 0;
    std::array<double, channel_count> sum{}, squared{};
    std::array<double, 3> expected{};
    std::uint32_t expected_count = 0;
    Channels last{}, before{};
    std::array<std::uint32_t, channel_count> second{};  // second differences taken
    std::array<std::uint32_t, channel_count> ends{};
    std::array<std::int64_t, channel_count> changed_ns{};
    std::uint32_t seen = 0;  // samples ever, to 3
  };

  struct Place {
    std::size_t link = 0;
    std::array<double, 9> cell_from_link{};
    std::array<double, 3> position{};
  };

  void take_sample(std::size_t cell, const Channels& value, const LinkMotion* motion, std::int64_t stamp_ns) noexcept;

  std::vector<Place> place_;
  std::vector<CellWindow> rows_, done_;
  std::vector<Running> running_;
  std::uint32_t ticks_ = 0;
  std::int64_t begun_ns_ = 0, newest_ns_ = 0;
};

}  // namespace robotskin::health
