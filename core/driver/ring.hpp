// SPDX-License-Identifier: Apache-2.0
// A queue of fixed size from one thread to one other; neither waits, and what has no place is refused.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <optional>

namespace robotskin::driver {

template <class Item, std::size_t Capacity>
class Ring {
  static_assert((Capacity & (Capacity - 1)) == 0, "a power of two");

 public:
  bool push(const Item& item) {
    const std::size_t last = last_.load(std::memory_order_relaxed);
    if (last - first_.load(std::memory_order_acquire) == Capacity) return false;
    items_[last % Capacity] = item;
    last_.store(last + 1, std::memory_order_release);
    return true;
  }

  std::optional<Item> pop() {
    const std::size_t first = first_.load(std::memory_order_relaxed);
    if (first == last_.load(std::memory_order_acquire)) return std::nullopt;
    const Item item = items_[first % Capacity];
    first_.store(first + 1, std::memory_order_release);
    return item;
  }

 private:
  std::array<Item, Capacity> items_{};
  alignas(64) std::atomic<std::size_t> first_{0};
  alignas(64) std::atomic<std::size_t> last_{0};
};

}  // namespace robotskin::driver
