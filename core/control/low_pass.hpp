// SPDX-License-Identifier: Apache-2.0
// First-order low-pass filter of a vector, exact for a sampled and held input.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace robotskin::control {

// Of the way to its input that a first-order filter goes in a period; a bandwidth of 0 Hz lets everything pass.
inline double low_pass_share(double bandwidth_hz, double period_s) noexcept {
  return bandwidth_hz > 0 ? 1 - std::exp(-2 * M_PI * bandwidth_hz * period_s) : 1.0;
}

class LowPass {
 public:
  // A bandwidth of 0 Hz lets everything pass unchanged.
  LowPass(std::size_t count, double bandwidth_hz, double period_s)
      : value_(count), share_(low_pass_share(bandwidth_hz, period_s)) {}

  void reset() noexcept {
    for (double& value : value_) value = 0;
  }
  // The next step takes its input as it is: a filter that enters late does not come up from zero.
  void prime() noexcept { primed_ = true; }
  // (n) in and out; the result stays valid until the next step.
  std::span<const double> step(std::span<const double> input) noexcept {
    const double share = primed_ ? 1.0 : share_;
    primed_ = false;
    for (std::size_t i = 0; i < value_.size(); ++i) value_[i] += share * (input[i] - value_[i]);
    return value_;
  }

 private:
  std::vector<double> value_;
  double share_;
  bool primed_ = false;
};

}  // namespace robotskin::control
