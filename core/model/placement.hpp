// Placements as row-major 4 x 4 matrices in plain memory.
#pragma once

namespace robotskin {

// Writes a placement given by anything with rotation()(row, column) and translation()(row).
template <typename Placement>
void write_placement(const Placement& placement, double* out) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) out[4 * row + column] = placement.rotation()(row, column);
    out[4 * row + 3] = placement.translation()(row);
    out[12 + row] = 0.0;
  }
  out[15] = 1.0;
}

// a_from_c = a_from_b b_from_c; the three do not overlap.
inline void multiply_placements(const double* a_from_b, const double* b_from_c, double* a_from_c) noexcept {
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      double sum = 0.0;
      for (int inner = 0; inner < 4; ++inner) sum += a_from_b[4 * row + inner] * b_from_c[4 * inner + column];
      a_from_c[4 * row + column] = sum;
    }
  }
}

}  // namespace robotskin
