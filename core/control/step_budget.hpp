// SPDX-License-Identifier: Apache-2.0
// How much work a tick may do, counted in solver steps; on a real robot's ports a clock may end it, too.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace robotskin::control {

struct StepBudget {
  std::size_t most = 0;          // steps
  std::int64_t deadline_ns = 0;  // of steady_clock; 0: none, so that what is computed depends on its input alone
  std::size_t taken = 0;
  bool by_clock = false;  // the deadline has ended it

  static std::int64_t now_ns() noexcept {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
  }

  // One step, if there is one.
  bool take() noexcept {
    if (taken >= most || by_clock) return false;
    by_clock = deadline_ns > 0 && now_ns() >= deadline_ns;
    if (!by_clock) ++taken;
    return !by_clock;
  }
};

}  // namespace robotskin::control
