// SPDX-License-Identifier: Apache-2.0
#include "world/accelerometer.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>

namespace robotskin::world {

Accelerometer::Accelerometer(const Mounting& mounting) : mounting_(mounting) {
  for (const int body : mounting.cell_body) {
    auto known = std::find_if(links_.begin(), links_.end(), [body](const Link& link) { return link.body == body; });
    link_of_cell_.push_back(static_cast<int>(known - links_.begin()));
    if (known == links_.end()) links_.push_back({body, {}, {}, {}});
  }
}

void Accelerometer::update(const mjModel& model, const mjData& data) {
  for (Link& link : links_) {
    mjtNum velocity[6], acceleration[6];  // rotation first; the acceleration counts gravity as a push upwards
    mj_objectVelocity(&model, &data, mjOBJ_XBODY, link.body, velocity, 1);
    mj_objectAcceleration(&model, &data, mjOBJ_XBODY, link.body, acceleration, 1);
    link.turn = load3(velocity);
    link.angular = load3(acceleration);
    link.linear = load3(acceleration + 3);
  }
}

Vector3 Accelerometer::specific_force(std::size_t cell) const {
  const Link& link = links_[link_of_cell_[cell]];
  const Vector3& arm = mounting_.body_from_cell_translation[cell];
  return apply_transposed(mounting_.body_from_cell_rotation[cell],
                          link.linear + cross(link.angular, arm) + cross(link.turn, cross(link.turn, arm)));
}

}  // namespace robotskin::world
