// SPDX-License-Identifier: Apache-2.0
// The temperature a cell feels: it follows what touches it, or the air, with a first-order lag.
#pragma once

#include <vector>

#include "world/mounting.hpp"

namespace robotskin::world {

class Temperature {
 public:
  explicit Temperature(const Mounting& mounting);

  // From `time_s` on the cell is touched by this object, -1: by none.
  void touch(std::size_t cell, int object, double time_s);

  double surface_temperature(std::size_t cell, double time_s) const;  // degrees Celsius
  double board_temperature(std::size_t cell, double time_s) const;    // degrees Celsius, behind the surface

 private:
  struct Cell {
    double surface_c, board_c, towards_c, since_s;
  };

  const Mounting& mounting_;
  std::vector<Cell> cells_;
};

}  // namespace robotskin::world
