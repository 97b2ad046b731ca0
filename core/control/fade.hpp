// SPDX-License-Identifier: Apache-2.0
// A share that goes to its target without a step, so that nothing is switched on or off abruptly.
#pragma once

#include <algorithm>

namespace robotskin::control {

// The value moves along a smoothstep; its slope never exceeds 1.5 / duration.
class Fade {
 public:
  explicit Fade(double duration_s, double start = 0.0) : duration_s_(duration_s), position_(start) {}

  // One period towards 1 (on) or 0 (off); returns the value.
  double step(bool on, double period_s) noexcept {
    const double change = duration_s_ > 0 ? period_s / duration_s_ : 1.0;
    position_ = std::clamp(position_ + (on ? change : -change), 0.0, 1.0);
    return value();
  }
  void set(double position) noexcept { position_ = position; }
  double value() const noexcept { return position_ * position_ * (3 - 2 * position_); }
  bool settled(bool on) const noexcept { return position_ == (on ? 1.0 : 0.0); }

 private:
  double duration_s_;
  double position_;  // 0 to 1, linear in time
};

}  // namespace robotskin::control
