// SPDX-License-Identifier: Apache-2.0
// The constant part of a skin: which cell sits where on which link, and which its neighbours are.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "driver/sample.hpp"
#include "skin/calibration.hpp"

namespace robotskin::skin {

// The host's name of a cell: section-unit group in the upper half, 14-bit wire id in the lower.
using driver::CellKey;

constexpr CellKey cell_key(std::uint16_t group, std::uint16_t id) {
  return (static_cast<CellKey>(group) << 16) | id;
}

struct Neighbour {
  std::int32_t cell = -1;  // index into the model's arrays, -1: nothing plugged in
  std::uint8_t port = 0;   // the neighbour's port, 1 to 4
};

// Struct of arrays, cell axis first; N cells, L links.
struct SkinModel {
  std::vector<std::string> link_names;                            // (L)
  std::vector<CellKey> key;                                       // (N) unique
  std::vector<std::int32_t> link;                                 // (N) index into link_names
  std::vector<std::array<double, 9>> link_from_cell_rotation;     // (N) row-major; z column is the outward normal
  std::vector<std::array<double, 3>> link_from_cell_translation;  // (N) metres
  std::vector<std::array<Neighbour, 4>> neighbours;               // (N) by own port - 1
  std::vector<std::int32_t> patch;                                // (N) index of the patch, -1: none
  std::vector<ForceCalibration> force_calibration;                // (N), or none: forces are as sensors show them

  std::size_t size() const { return key.size(); }
};

}  // namespace robotskin::skin
