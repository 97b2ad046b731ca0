// SPDX-License-Identifier: Apache-2.0
// A cell's contribution to torque sums, from Python.
#pragma once

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "robotskin/torque.h"

namespace robotskin::bindings {

inline rs_contribution contribution_of(unsigned limb, const std::vector<std::int32_t>& torque, bool active,
                                       unsigned age) {
  constexpr std::size_t joints = RS_TORQUE_PARTS * RS_JOINTS_PER_PART;
  if (limb > 15) throw std::invalid_argument("limb " + std::to_string(limb) + " is not one of 0 to 15");
  if (torque.size() > joints)
    throw std::invalid_argument(std::to_string(torque.size()) + " joints: a cell knows at most " +
                                std::to_string(joints));
  rs_contribution contribution{};
  std::copy(torque.begin(), torque.end(), contribution.joint);
  contribution.limb = static_cast<std::uint8_t>(limb);
  contribution.parts = static_cast<std::uint8_t>((torque.size() + RS_JOINTS_PER_PART - 1) / RS_JOINTS_PER_PART);
  contribution.active = active;
  contribution.age = static_cast<std::uint8_t>(std::min(age, 7U));
  return contribution;
}

}  // namespace robotskin::bindings
