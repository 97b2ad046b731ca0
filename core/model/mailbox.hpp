// SPDX-License-Identifier: Apache-2.0
// The newest value from one thread to another, or from one process to another through memory that both share: neither
// side ever waits for the other.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace robotskin {

// Three places: one is written, one is read, one is between. `Value` must be copied without allocation.
template <typename Value>
class Mailbox {
 public:
  void put(const Value& value) noexcept {
    places_[writing_] = value;
    writing_ = between_.exchange(static_cast<std::uint8_t>(writing_ | unread), std::memory_order_acq_rel) & place;
  }

  // The newest value, if there is one that was not taken yet; it holds until the next call.
  const Value* take() noexcept {
    if ((between_.load(std::memory_order_acquire) & unread) == 0) return nullptr;
    reading_ = between_.exchange(reading_, std::memory_order_acq_rel) & place;
    return &places_[reading_];
  }

 private:
  static constexpr std::uint8_t unread = 4, place = 3;

  std::array<Value, 3> places_{};
  std::uint8_t writing_ = 0, reading_ = 1;
  std::atomic<std::uint8_t> between_{2};
};

}  // namespace robotskin
