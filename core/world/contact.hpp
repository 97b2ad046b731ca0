// SPDX-License-Identifier: Apache-2.0
// Touch: MuJoCo's contact forces, given to the force sensors of the cells they press.
//
// An object that presses a link meets a soft skin: what presses is shared by all cells in reach, each in proportion
// to its indentation. For each pair of object and link the normal forces of all contacts are added up and given out
// again in proportion to contact depth, so the cells' sum equals the contact force. Within a cell the silicone spreads
// a touch over the face: the sensors' shares are barycentric coordinates of a centre of pressure that lies so far
// inwards that a touch at a corner gives 2/3 to the nearest sensor. So 15 N anywhere on one cell are within its range
// of 10 N.
//
// A sensor measures along its own normal: of a contact force that comes aslant it feels the projection, friction
// included. The soft layer carries a share of a cell's force over to each neighbour, so that the sum stays.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "world/imperfections.hpp"
#include "world/mounting.hpp"

namespace robotskin::world {

class Contacts {
 public:
  Contacts(const mjModel_& model, const Mounting& mounting, const Imperfections& imperfections);

  // Reads the contacts of the last physics step. Allocates nothing.
  void update(const mjModel_& model, const mjData_& data);

  // (N, 3) newton, what each force sensor feels, >= 0 and not yet limited by its range.
  const std::vector<std::array<double, 3>>& sensor_force() const { return sensor_force_; }
  // (N) index of the object that presses a cell most, -1: none.
  const std::vector<int>& toucher() const { return toucher_; }
  // Cells that are pressed or were in the step before, each once.
  const std::vector<int>& changed() const { return changed_; }
  // (O) newton, MuJoCo's normal contact force of each object on all cells.
  const std::vector<double>& object_force() const { return object_force_; }

 private:
  struct Press {
    int cell;
    int pair;  // object times link
    double depth_m;
    double force_n;  // normal to the contact
    double felt;     // share of it that acts along the cell's normal
    Vector3 point;   // world frame
  };

  void spread();
  void change(int cell);

  const Mounting& mounting_;
  bool projection_;
  double crosstalk_;
  std::vector<int> cell_of_geom_;    // (ngeom)
  std::vector<int> object_of_body_;  // (nbody)
  std::vector<Press> presses_;
  std::vector<std::array<double, 3>> sensor_force_;
  std::vector<double> toucher_depth_m_;
  std::vector<int> toucher_;
  std::vector<int> touched_;
  std::vector<int> changed_;
  std::vector<std::uint8_t> marked_;
  std::vector<double> object_force_;
  std::vector<std::array<double, 3>> pressed_;  // (N) before the soft layer spreads it
  std::vector<int> beside_;                     // cells that feel their neighbours alone
};

// How a force of 1 at (x, y) metres on a cell's face is shared by its three sensors: >= 0, sum 1.
std::array<double, 3> sensor_shares(double x_m, double y_m);

}  // namespace robotskin::world
