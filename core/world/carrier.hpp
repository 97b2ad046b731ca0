// SPDX-License-Identifier: Apache-2.0
// A thing that goes its way whatever it meets: a table that moves, a support that sinks, a shaker.
//
// It is a heavy body on a free joint, whose place and velocity are set before each physics step. So what lies on it is
// carried along by friction, which a body that only jumps from place to place would not do.
#pragma once

#include <array>
#include <vector>

#include "world/mounting.hpp"

namespace robotskin::world {

struct Waypoint {
  double time_s;  // since the path began, rising
  Vector3 position_m;
  std::array<double, 4> orientation;  // unit quaternion, w first
};

class Carrier {
 public:
  // `joint`: its free joint. `smooth`: it rests at each waypoint and goes between them as a cosine does; else straight
  // on. `begin_s`: when the path begins; before, it stays at the first waypoint. `repeats`: begins anew after the last.
  Carrier(int joint, std::vector<Waypoint> path, bool smooth, bool repeats, double begin_s);

  // Another path for the same joint.
  void follow(std::vector<Waypoint> path, bool smooth, bool repeats, double begin_s);

  // Sets place and velocity for this time. Allocates nothing.
  void place(const mjModel_& model, mjData_& data, double time_s) const;

 private:
  int joint_;
  std::vector<Waypoint> path_;
  bool smooth_, repeats_;
  double begin_s_;
};

}  // namespace robotskin::world
