// What a proximity sensor sees: the nearest object in a cone about the cell's normal.
//
// The light of the emitter is followed along the normal and along six rays on a cone around it; the shortest counts.
// Only hands and objects reflect, not the robot itself.
#pragma once

#include <vector>

#include "world/mounting.hpp"

namespace robotskin::world {

class Reflection {
 public:
  Reflection(const mjModel_& model, const Mounting& mounting);

  // Metres from the cell's face along the best ray, 0 while touching, +infinity beyond the sensor's reach.
  double distance(const mjModel_& model, const mjData_& data, std::size_t cell) const;

 private:
  const Mounting& mounting_;
  std::vector<int> object_geom_;
};

}  // namespace robotskin::world
