// SPDX-License-Identifier: Apache-2.0
#include "world/carrier.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace robotskin::world {

Carrier::Carrier(int joint, std::vector<Waypoint> path, bool smooth, bool repeats, double begin_s) : joint_(joint) {
  follow(std::move(path), smooth, repeats, begin_s);
}

void Carrier::follow(std::vector<Waypoint> path, bool smooth, bool repeats, double begin_s) {
  path_ = std::move(path);
  smooth_ = smooth;
  repeats_ = repeats;
  begin_s_ = begin_s;
}

void Carrier::place(const mjModel& model, mjData& data, double time_s) const {
  if (path_.empty()) return;
  const double length_s = path_.back().time_s;
  double since_s = std::max(time_s - begin_s_, 0.0);
  if (repeats_ && length_s > 0) since_s = std::fmod(since_s, length_s);
  const auto next = std::upper_bound(path_.begin(), path_.end(), since_s,
                                     [](double time, const Waypoint& point) { return time < point.time_s; });
  const Waypoint& to = next == path_.end() ? path_.back() : *next;
  const Waypoint& from = next == path_.begin() ? path_.front() : *(next - 1);
  const double lasts_s = to.time_s - from.time_s;
  double share = 0, speed = 0;  // of the way between the two, and per second
  if (lasts_s > 0 && time_s >= begin_s_) {
    const double part = (since_s - from.time_s) / lasts_s;
    share = smooth_ ? 0.5 - 0.5 * std::cos(M_PI * part) : part;
    speed = (smooth_ ? 0.5 * M_PI * std::sin(M_PI * part) : 1) / lasts_s;
  }
  mjtNum* position = data.qpos + model.jnt_qposadr[joint_];
  mjtNum* velocity = data.qvel + model.jnt_dofadr[joint_];
  for (int i = 0; i < 3; ++i) {
    position[i] = from.position_m[i] + share * (to.position_m[i] - from.position_m[i]);
    velocity[i] = speed * (to.position_m[i] - from.position_m[i]);
  }
  // The turn between two orientations, in the body's frame, which a free joint's velocity is in, too.
  mjtNum turn[3];
  mju_subQuat(turn, to.orientation.data(), from.orientation.data());
  std::copy(from.orientation.begin(), from.orientation.end(), position + 3);
  mju_quatIntegrate(position + 3, turn, share);
  for (int i = 0; i < 3; ++i) velocity[3 + i] = speed * turn[i];
}

}  // namespace robotskin::world
