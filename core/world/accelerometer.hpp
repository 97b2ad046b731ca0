// SPDX-License-Identifier: Apache-2.0
// What an accelerometer feels in each cell: the specific force of the point of the link where the cell sits.
#pragma once

#include <vector>

#include "world/mounting.hpp"

namespace robotskin::world {

class Accelerometer {
 public:
  explicit Accelerometer(const Mounting& mounting);

  // Reads the links' motion of the last physics step; needs mj_rnePostConstraint. Allocates nothing.
  void update(const mjModel_& model, const mjData_& data);

  // m/s^2 in the cell frame: acceleration minus gravity, with the tangential and centripetal terms of the link's turn.
  Vector3 specific_force(std::size_t cell) const;

 private:
  struct Link {
    int body;
    Vector3 linear;   // m/s^2, specific force at the link's origin, link frame
    Vector3 angular;  // rad/s^2
    Vector3 turn;     // rad/s
  };

  const Mounting& mounting_;
  std::vector<Link> links_;
  std::vector<int> link_of_cell_;  // (N) index into links_
};

}  // namespace robotskin::world
