// SPDX-License-Identifier: Apache-2.0
// Which sequence numbers of a session have been seen: tolerates re-ordering, lets nothing through twice.
#pragma once

#include <array>
#include <cstdint>

namespace robotskin::driver {

class SequenceWindow {
 public:
  static constexpr std::uint32_t width = 1024;  // datagrams; 200 ms of the busiest unit

  enum class Verdict : std::uint8_t { fresh, seen, too_old };

  void reset() { *this = {}; }

  Verdict take(std::uint32_t sequence) {
    if (started_ == 0) {
      started_ = 1;
      newest_ = first_ = sequence;
      span_ = received_ = 1;
      set(sequence);
      return Verdict::fresh;
    }
    const auto ahead = static_cast<std::int32_t>(sequence - newest_);
    if (ahead > 0) {
      const std::uint32_t step = static_cast<std::uint32_t>(ahead);
      if (step >= width) {
        seen_.fill(0);
      } else {
        for (std::uint32_t i = 1; i <= step; ++i) clear(newest_ + i);
      }
      newest_ = sequence;
      span_ += step;
    } else {
      if (static_cast<std::uint32_t>(-static_cast<std::int64_t>(ahead)) >= width) return Verdict::too_old;
      if (get(sequence)) return Verdict::seen;
      if (span_ <= width && static_cast<std::int32_t>(sequence - first_) < 0) {
        span_ += first_ - sequence;
        first_ = sequence;
      }
    }
    ++received_;
    set(sequence);
    return Verdict::fresh;
  }

  // Datagrams between the first and the newest that have not come (yet).
  std::uint64_t missing() const { return span_ - received_; }

 private:
  bool get(std::uint32_t sequence) const { return seen_[sequence % width / 64] >> (sequence % 64) & 1U; }
  void set(std::uint32_t sequence) { seen_[sequence % width / 64] |= std::uint64_t{1} << (sequence % 64); }
  void clear(std::uint32_t sequence) { seen_[sequence % width / 64] &= ~(std::uint64_t{1} << (sequence % 64)); }

  std::array<std::uint64_t, width / 64> seen_{};
  std::uint64_t span_ = 0;  // from the first to the newest
  std::uint64_t received_ = 0;
  std::uint32_t newest_ = 0;
  std::uint32_t first_ = 0;
  std::uint8_t started_ = 0;  // no bool: windows are restored from the bytes of a recording
};

}  // namespace robotskin::driver
