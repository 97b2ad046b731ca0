// SPDX-License-Identifier: Apache-2.0
// What lines that lose or damage frames by chance may take: counted, and bounded by their error rates.
#pragma once

#include <cmath>
#include <cstdint>

#include "robotskin/timing.h"
#include "world/network/network.hpp"

namespace robotskin::campaign {

// The share of frames that a line loses or damages.
inline double frame_loss(const world::LineQuality& line) {
  constexpr double bits = RS_FRAME_US * 4;  // at 4 Mb/s
  return line.lost_share + 1 - std::pow(1 - line.bit_error_rate, bits);
}

// Of ticks, one on each of so many lines in a row, as many as may be lost: what is expected three times, and chance.
inline std::int64_t ticks_lost(double frame_loss, std::int32_t hops) {
  return frame_loss == 0 ? 0 : 1 + static_cast<std::int64_t>(std::ceil(3 * frame_loss * hops));
}

class LineLosses {
 public:
  explicit LineLosses(const world::LineQuality& line) : frame_loss_(frame_loss(line)) {}

  bool whole() const { return frame_loss_ == 0; }
  // Something has had to come over so many lines.
  void due(std::int32_t hops) { at_most_ += factor * frame_loss_ * hops; }
  void add(std::int64_t lost) { lost_ += lost; }

  std::int64_t lost() const { return lost_; }
  std::int64_t at_most() const { return static_cast<std::int64_t>(at_most_); }
  bool too_many() const { return lost_ > at_most(); }

 private:
  // A frame that is lost may take those behind it along, where it makes a link look dead; and chance has its tails.
  static constexpr double factor = 3, more = 20;

  double frame_loss_, at_most_ = more;
  std::int64_t lost_ = 0;
};

}  // namespace robotskin::campaign
