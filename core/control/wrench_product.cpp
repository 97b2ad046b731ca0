// SPDX-License-Identifier: Apache-2.0
#include "control/wrench_product.hpp"

#include <cstring>

#include "control/instruction_sets.hpp"

namespace robotskin::control {
namespace {

using Lanes = float __attribute__((vector_size(sizeof(float) * WrenchBlock::columns)));

}  // namespace

// CMake lets the compiler reorder the sums of this file, which makes the last one of a run a tree.
ROBOTSKIN_INSTRUCTION_SETS
void add_wrenches(const WrenchRun* runs, std::size_t run_count, const WrenchBlock* blocks, const float* force,
                  double* wrenches) noexcept {
  for (std::size_t run = 0; run < run_count; ++run) {
    Lanes sums[6]{};
    const float* next = force + runs[run].first_force;
    for (const WrenchBlock* end = blocks + runs[run].block_count; blocks != end; ++blocks) {
      Lanes forces;
      std::memcpy(&forces, next, sizeof forces);
      next += WrenchBlock::columns;
#pragma GCC unroll 6
      for (std::size_t row = 0; row < 6; ++row) {
        Lanes entries;
        std::memcpy(&entries, blocks->rows[row], sizeof entries);
        sums[row] += entries * forces;  // [Cheng19 eq. 23]
      }
    }
    double* wrench = wrenches + 6 * runs[run].joint;
    for (std::size_t row = 0; row < 6; ++row) {
      float lane[WrenchBlock::columns];
      std::memcpy(lane, &sums[row], sizeof lane);
      wrench[row] += ((lane[0] + lane[4]) + (lane[1] + lane[5])) + ((lane[2] + lane[6]) + (lane[3] + lane[7]));
    }
  }
}

}  // namespace robotskin::control
