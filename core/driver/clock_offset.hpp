// How far the host's clock is ahead of a section unit's: the least of (arrival - departure) in the last second or two.
//
// The least delayed datagram shows the offset best; two windows in turn forget old ones, so that drift is followed.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace robotskin::driver {

class ClockOffset {
 public:
  static constexpr std::int64_t window_ns = 1'000'000'000;

  void reset() { *this = {}; }

  void take(std::uint64_t unit_ns, std::int64_t host_ns) {
    // Unsigned, for a clock that starts anywhere.
    const auto offset = static_cast<std::int64_t>(static_cast<std::uint64_t>(host_ns) - unit_ns);
    if (!started_ || host_ns - window_start_ns_ >= window_ns) {
      before_ = started_ && host_ns - window_start_ns_ < 2 * window_ns ? now_ : none;
      now_ = offset;
      window_start_ns_ = host_ns;
      started_ = true;
    }
    now_ = std::min(now_, offset);
  }

  std::int64_t offset_ns() const { return std::min(before_, now_); }

  // A time of the unit on the host's clock.
  std::int64_t host_ns(std::uint64_t unit_ns) const {
    return static_cast<std::int64_t>(unit_ns + static_cast<std::uint64_t>(offset_ns()));
  }

 private:
  static constexpr std::int64_t none = std::numeric_limits<std::int64_t>::max();
  std::int64_t before_ = none;
  std::int64_t now_ = none;
  std::int64_t window_start_ns_ = 0;
  bool started_ = false;
};

}  // namespace robotskin::driver
