// SPDX-License-Identifier: Apache-2.0
// What is known of a standing robot's balance in one tick: estimated from joints, inertial unit and feet.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "control/support_polygon.hpp"
#include "model/spatial.hpp"

namespace robotskin::control {

// World frame: the floor is z = 0, its origin between the soles where the estimate began. SI units.
struct StandingState {
  Vector3 centre_of_mass{};
  Vector3 com_velocity{};
  SupportPolygon support;
  bool imu_counts = false;    // the inertial unit is heard and not stuck; else the tilt is that of the legs
  bool forces_count = false;  // every foot's force is heard: `zmp`, `load_n` and `foot_pressure` are known
  Vector2 zmp{};              // zero-moment point, where the floor's force on the feet acts
  double load_n = 0;          // of the floor on all feet, upwards
  std::array<double, 2> foot_load_n{};
  std::array<Vector2, 2>
      foot_pressure{};                  // centre of pressure of each foot in its link's frame, from the sole's middle
  std::array<Vector2, 2> foot_place{};  // middle of each sole

  // Where the robot would come to rest by itself: the centre of mass plus its velocity over sqrt(g / h).
  Vector2 capture_point() const noexcept {
    const double rate = std::sqrt(9.81 / std::max(centre_of_mass[2], 0.1));
    return {centre_of_mass[0] + com_velocity[0] / rate, centre_of_mass[1] + com_velocity[1] / rate};
  }
};

}  // namespace robotskin::control
