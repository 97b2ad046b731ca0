// SPDX-License-Identifier: Apache-2.0
#include "loop/paced_loop.hpp"

#include <algorithm>
#include <string>

#include "driver/clock.hpp"
#include "loop/loop_error.hpp"

namespace robotskin::loop {
namespace {

std::int64_t now() noexcept {
  return driver::monotonic_ns();
}

}  // namespace

PacedLoop::PacedLoop(SkinLoop& loop, double period_s, bool realtime)
    : loop_(loop), period_ns_(static_cast<std::int64_t>(period_s * 1e9)), wanted_realtime_(realtime) {
  if (period_ns_ <= 0) throw LoopError("period of " + std::to_string(period_s) + " s: must be greater than 0");
}

void PacedLoop::run(double seconds) noexcept {
  const driver::RealtimeWhile place(wanted_realtime_);
  realtime_ = place.realtime();
  const std::int64_t ends_ns = now() + static_cast<std::int64_t>(seconds * 1e9);
  // A robot that tells its states sets the pace; where one is missing, the tick comes half a period late.
  const std::int64_t grace_ns = loop_.port().period_s() > 0 ? period_ns_ / 2 : 0;
  std::int64_t due_ns = last_ns_ + period_ns_;
  for (;;) {
    // A state that has been waited for must be answered: one that ended a run would wait for half a period.
    if (now() >= ends_ns) return;
    loop_.port().await_state(std::max(due_ns + grace_ns, now()));
    const std::int64_t now_ns = now();
    if (last_ns_ != 0) {
      const std::int64_t gap_ns = now_ns - last_ns_;
      worst_gap_ns_ = std::max(worst_gap_ns_, gap_ns);
      if (gap_ns > period_ns_ + period_ns_ / 2 + grace_ns) ++late_;
    }
    loop_.step(now_ns);
    ++ticks_;
    last_ns_ = now_ns;
    due_ns = grace_ns > 0 ? now_ns + period_ns_ : std::max(due_ns + period_ns_, now_ns);
  }
}

}  // namespace robotskin::loop
