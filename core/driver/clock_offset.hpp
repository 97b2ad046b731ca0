// SPDX-License-Identifier: Apache-2.0
// How far the host's clock is ahead of a section unit's: the least of (arrival - departure) in the session so far.
//
// The least delayed datagram shows the offset best. Two quartz clocks run apart, so the least may rise, but only as
// fast as they can: what the network holds up for long stays as old as it is, and never becomes the new measure of now.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace robotskin::driver {

class ClockOffset {
 public:
  static constexpr std::int64_t drift_ppm = 200;  // between host and section unit; quartz keeps within half of it

  void reset() { *this = {}; }

  void take(std::uint64_t unit_ns, std::int64_t host_ns) {
    // Unsigned, for a clock that starts anywhere.
    const auto offset = static_cast<std::int64_t>(static_cast<std::uint64_t>(host_ns) - unit_ns);
    if (offset_ == none) {
      risen_to_ns_ = host_ns;
    } else {
      constexpr std::int64_t per_ns = 1'000'000 / drift_ppm;
      const std::int64_t rise_ns = std::max<std::int64_t>(host_ns - risen_to_ns_, 0) / per_ns;
      risen_to_ns_ += rise_ns * per_ns;
      offset_ = offset_ > none - rise_ns ? none : offset_ + rise_ns;
    }
    offset_ = std::min(offset_, offset);
  }

  std::int64_t offset_ns() const { return offset_; }

  // Whether every time in it is within the limit, as those of a true clock are.
  bool possible(std::int64_t limit_ns) const { return risen_to_ns_ > -limit_ns && risen_to_ns_ < limit_ns; }

  // A time of the unit on the host's clock.
  std::int64_t host_ns(std::uint64_t unit_ns) const {
    return static_cast<std::int64_t>(unit_ns + static_cast<std::uint64_t>(offset_ns()));
  }

 private:
  static constexpr std::int64_t none = std::numeric_limits<std::int64_t>::max();
  std::int64_t offset_ = none;
  std::int64_t risen_to_ns_ = 0;  // host clock up to which the offset has been let rise
};

}  // namespace robotskin::driver
