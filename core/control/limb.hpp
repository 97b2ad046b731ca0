// SPDX-License-Identifier: Apache-2.0
// The limbs of a robot: which joints belong together, and which limb takes what another leaves undone.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "model/robot_model.hpp"

namespace robotskin::control {

struct Limb {
  std::string name;
  std::vector<std::string> joints;
  std::string parent;                        // name of the limb that carries this one; empty: none does
  std::vector<double> largest_acceleration;  // (joints) rad/s^2 or m/s^2
};

// The same by index.
struct LimbJoints {
  static constexpr std::size_t no_parent = static_cast<std::size_t>(-1);

  std::string name;
  std::vector<std::size_t> joints;
  std::size_t parent = no_parent;
  std::vector<double> largest_acceleration;
};

// Limbs by index, in their order, in which a parent comes before what it carries. Throws ControlError for no limbs, a
// limb without joints or of a name twice, a joint in two limbs, accelerations that do not fit, and a parent that is
// none of the limbs before, or that does not carry the limb; ModelError for an unknown joint.
std::vector<LimbJoints> indexed_limbs(const RobotModel& robot, const std::vector<Limb>& limbs);

}  // namespace robotskin::control
