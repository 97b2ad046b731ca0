// SPDX-License-Identifier: Apache-2.0
// A foot on which a robot stands.
#pragma once

#include <array>
#include <string>

#include "model/spatial.hpp"

namespace robotskin {

// The sole is a rectangle; the frame of the foot's link has z up where the robot stands on level ground.
struct Foot {
  std::string link;
  Vector3 sole;                // metres, middle of the sole's lower face in that frame
  std::array<double, 2> half;  // metres, half its length (x) and width (y)
};

}  // namespace robotskin
