// SPDX-License-Identifier: Apache-2.0
// Which parts of a MuJoCo model are skin cells and which are things that touch them.
#pragma once

#include <array>
#include <vector>

#include "model/spatial.hpp"

struct mjModel_;
struct mjData_;

namespace robotskin::world {

// Struct of arrays; N cells, O objects. Indices are those of the MuJoCo model that Python compiled.
struct Mounting {
  std::vector<int> cell_body;                       // (N) the link a cell stands on
  std::vector<int> cell_geom;                       // (N) its hexagonal prism
  std::vector<Matrix3> body_from_cell_rotation;     // (N) z column is the outward normal
  std::vector<Vector3> body_from_cell_translation;  // (N) metres, centre of the outer face
  std::vector<std::array<int, 4>> cell_neighbours;  // (N) cell at each port, -1: none; empty: no cell has any
  std::vector<int> object_body;                     // (O) hands first, then the bodies of things
  std::vector<double> object_temperature;           // (O) degrees Celsius
  std::vector<double> object_reflectance;           // (O) what a proximity sensor sees of it; 0: drawn
  double ambient_temperature = 30;                  // degrees Celsius
  double skin_stiffness_n_per_m = 7500;             // of the foam under one cell
  std::vector<int> material_geom;                   // (M) geoms of things that are not rigid
  std::vector<double> material_stiffness_n_per_m;   // (M) of one side of the thing, or of what one cell finds
  std::vector<char> material_local;                 // (M) true: of what one cell finds
  std::vector<double> material_relaxes_by;          // (M) share of the force that a long press loses
  std::vector<double> material_relaxes_in_s;        // (M) time constant

  std::size_t cell_count() const { return cell_body.size(); }
  std::size_t object_count() const { return object_body.size(); }
};

}  // namespace robotskin::world
