// SPDX-License-Identifier: Apache-2.0
// A loop in real time: a tick as soon as the robot has measured, or once a period where its port cannot tell when.
#pragma once

#include <cstdint>

#include "loop/skin_loop.hpp"

namespace robotskin::loop {

class PacedLoop {
 public:
  // `period_s` is that of the cycle. `realtime`: while it runs, its thread goes before all that are not real-time,
  // where the system permits it. The loop is kept and must outlive this. Throws LoopError for a period of 0 or less.
  PacedLoop(SkinLoop& loop, double period_s, bool realtime = false);

  // Ticks for a time on the host's monotonic clock, and until the tick that has begun is over. What is late is not
  // caught up with.
  void run(double seconds) noexcept;

  SkinLoop& loop() noexcept { return loop_; }
  std::uint64_t ticks() const noexcept { return ticks_; }
  std::uint64_t late_ticks() const noexcept { return late_; }  // by more than half a period
  double worst_gap_s() const noexcept { return static_cast<double>(worst_gap_ns_) * 1e-9; }
  bool realtime() const noexcept { return realtime_; }  // of the last run
  void forget() noexcept { ticks_ = late_ = 0, worst_gap_ns_ = 0; }

 private:
  SkinLoop& loop_;
  std::int64_t period_ns_;
  std::int64_t last_ns_ = 0;  // of the last tick; 0: none yet
  std::int64_t worst_gap_ns_ = 0;
  std::uint64_t ticks_ = 0, late_ = 0;
  bool wanted_realtime_ = false, realtime_ = false;
};

}  // namespace robotskin::loop
