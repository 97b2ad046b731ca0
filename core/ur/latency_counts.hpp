// SPDX-License-Identifier: Apache-2.0
// How long something took, counted in steps of 10 us by one thread and read by another.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace robotskin::ur {

class LatencyCounts {
 public:
  static constexpr std::int64_t step_ns = 10'000;

  void add(std::int64_t duration_ns) noexcept {
    const auto step = static_cast<std::size_t>(duration_ns < 0 ? 0 : duration_ns / step_ns);
    counts_[step < counts_.size() ? step : counts_.size() - 1].fetch_add(1, std::memory_order_relaxed);
  }
  std::uint64_t total() const noexcept {
    std::uint64_t all = 0;
    for (const auto& one : counts_) all += one.load(std::memory_order_relaxed);
    return all;
  }
  // Seconds that a share of all stayed below; 0 where nothing was counted. 20 ms stands for all that is more.
  double quantile(double share) const noexcept {
    const double wanted = share * static_cast<double>(total());
    double so_far = 0;
    for (std::size_t i = 0; i < counts_.size() && wanted > 0; ++i) {
      so_far += static_cast<double>(counts_[i].load(std::memory_order_relaxed));
      if (so_far >= wanted) return static_cast<double>(i + 1) * step_ns * 1e-9;
    }
    return 0;
  }
  void clear() noexcept {
    for (auto& one : counts_) one.store(0, std::memory_order_relaxed);
  }

 private:
  std::array<std::atomic<std::uint64_t>, 2000> counts_{};
};

}  // namespace robotskin::ur
