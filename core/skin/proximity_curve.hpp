// SPDX-License-Identifier: Apache-2.0
// How a proximity sensor's reading falls with distance: the one home of the curve and of its inverse.
//
// Infrared reflection seen through a cover falls with the square of the distance plus a constant d0. With d0 = 6 mm
// the reading is 9200 counts of 65536 at 10 mm, 750 at 50 mm, 210 at 100 mm and 56 at 200 mm, the reach of a VCNL4010.
#pragma once

#include <cmath>
#include <limits>

namespace robotskin::skin {

inline constexpr double proximity_cover_m = 0.006;  // d0
inline constexpr double proximity_reach_m = 0.200;  // beyond it a reading tells nothing

// Share of full scale, 0 to 1, for an object at `distance_m` >= 0 in front of the cell; 0 for infinity.
constexpr double proximity_from_distance(double distance_m) {
  if (!(distance_m <= proximity_reach_m)) return 0;
  const double ratio = proximity_cover_m / (proximity_cover_m + (distance_m > 0 ? distance_m : 0));
  return ratio * ratio;
}

inline constexpr double proximity_at_reach = proximity_from_distance(proximity_reach_m);

// Metres from a share of full scale; +infinity where the reading is weaker than that of an object at the reach.
inline double distance_from_proximity(double share) {
  if (!(share >= proximity_at_reach)) return std::numeric_limits<double>::infinity();
  if (share >= 1) return 0;
  return proximity_cover_m / std::sqrt(share) - proximity_cover_m;
}

}  // namespace robotskin::skin
