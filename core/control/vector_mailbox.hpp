// SPDX-License-Identifier: Apache-2.0
// A vector that one thread hands to the control tick without lock or allocation.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace robotskin::control {

// One writer at a time, one reader. The reader sees whole vectors only: it takes what was written last, or leaves it
// for its next look if the writer is at work.
class VectorMailbox {
 public:
  explicit VectorMailbox(std::size_t size) : value_(size) {}

  std::size_t size() const noexcept { return value_.size(); }

  // value has size() entries.
  void post(std::span<const double> value) noexcept {
    const std::uint32_t turn = turn_.load(std::memory_order_relaxed);
    turn_.store(turn + 1, std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_release);
    for (std::size_t i = 0; i < value_.size(); ++i) value_[i].store(value[i], std::memory_order_relaxed);
    turn_.store(turn + 2, std::memory_order_release);
  }

  // True if there was something new; then out has it, and else what it had.
  [[nodiscard]] bool take(std::span<double> out, std::span<double> scratch) noexcept {
    const std::uint32_t before = turn_.load(std::memory_order_acquire);
    if (before == taken_ || before % 2 != 0) return false;
    for (std::size_t i = 0; i < value_.size(); ++i) scratch[i] = value_[i].load(std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_acquire);
    if (turn_.load(std::memory_order_relaxed) != before) return false;
    for (std::size_t i = 0; i < value_.size(); ++i) out[i] = scratch[i];
    taken_ = before;
    return true;
  }

  // What was written until now is never taken.
  void drop() noexcept { taken_ = turn_.load(std::memory_order_acquire) & ~1U; }

 private:
  std::vector<std::atomic<double>> value_;
  std::atomic<std::uint32_t> turn_{0};  // odd while the writer is at work
  std::uint32_t taken_ = 0;
};

}  // namespace robotskin::control
