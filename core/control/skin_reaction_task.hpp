// SPDX-License-Identifier: Apache-2.0
// The reaction to touch: a touch moves what it touches [Cheng19 eq. 14 to 17], by [Cheng19 eq. 22 to 25].
#pragma once

#include <memory>
#include <vector>

#include "control/low_pass.hpp"
#include "control/task.hpp"
#include "control/touch_wrench.hpp"

namespace robotskin::control {

// Claims one row for each touched body, the motion along the wrench that it feels. Its torque is the sum of the host or
// the skin's own, whichever is asked for (skin_source.hpp).
class SkinReactionTask final : public Task {
 public:
  // Torques are filtered at `bandwidth_hz` (0: not). `own_scale`: the touch's gains over those that the cells have been
  // told. Throws ControlError.
  explicit SkinReactionTask(std::shared_ptr<TouchWrench> touch, double bandwidth_hz = 0, double period_s = 0.001,
                            double own_scale = 1);
  void start(const TaskInput&) noexcept override { filter_.prime(); }
  [[nodiscard]] bool update(const TaskInput& input) noexcept override;
  std::span<const float> magnitudes() const noexcept { return touch_->magnitudes(); }  // (N) newton
  std::span<const double> host_torque() const noexcept { return touch_->torque(); }    // (n) Nm, the host's sum
  std::span<const double> used_torque() const noexcept { return source_.torque(); }    // (n) Nm, before the filter
  double source_share() const noexcept { return source_.share(); }  // 1: all of the torque is the skin's own

  static constexpr double source_fade_s = 0.25;
  // A robot that stands yields the most to touches that together press with this share of its weight.
  static constexpr double bearable_weight_share = 0.09;

 private:
  std::shared_ptr<TouchWrench> touch_;
  SkinSourceSwitch source_;
  LowPass filter_;
  double own_scale_;
};

}  // namespace robotskin::control
