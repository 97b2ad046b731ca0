// SPDX-License-Identifier: Apache-2.0
// What a proximity sensor sees: what reflects most in a cone about the cell's normal.
//
// The light of the emitter is followed along the normal and along six rays on a cone around it; of each surface the
// nearest point counts, and of all surfaces the one that sends back most. Hands and objects are looked for at every
// measurement. The robot's other links and the floor change slowly as seen from a cell, and are looked for again only
// when the joints have moved. A cell does not see its own link: that lies behind its face, and what light leaks back
// through cover and seam is constant and taken off as offset.
#pragma once

#include <cstdint>
#include <vector>

#include "world/imperfections.hpp"
#include "world/mounting.hpp"

namespace robotskin::world {

struct Seen {
  double distance_m;  // from the cell's face along the best ray, 0 while touching, +infinity beyond the sensor's reach
  double reflectance;
};

class Proximity {
 public:
  Proximity(const mjModel_& model, const Mounting& mounting, const Imperfections& imperfections, std::uint64_t seed);

  // After each physics step; the joints of the robot alone are looked at.
  void update(const mjData_& data, const std::vector<int>& position_address);

  // Looks at the robot's links and the floor, too, however old what is known of them.
  Seen look(const mjModel_& model, const mjData_& data, std::size_t cell) const;
  // The same for less work: links and floor may be as seen before the joints moved by some milliradians.
  Seen measure(const mjModel_& model, const mjData_& data, std::size_t cell);

  double reflectance_of_object(int object) const { return reflectance_[mounting_.object_body[object]]; }

 private:
  struct Face;
  struct Known {
    Seen seen;
    double travel;  // of the joints when it was seen, negative: never
  };

  Seen strongest(const mjModel_& model, const mjData_& data, const Face& face, const std::vector<int>& geoms,
                 double start_behind_m) const;

  const Mounting& mounting_;
  std::vector<int> object_geom_;
  std::vector<std::vector<int>> other_geom_;  // by body: links other than it and what stands in the world; or empty
  std::vector<double> reflectance_;           // (nbody)
  std::vector<Known> known_;                  // (N)
  std::vector<double> position_;
  double travel_ = 0;  // rad, how far the joints have moved so far
};

}  // namespace robotskin::world
