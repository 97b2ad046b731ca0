// SPDX-License-Identifier: Apache-2.0
// The product at the heart of the skin task: a constant 6 x n matrix times n scalar forces [Cheng19 eq. 22, 23].
//
// It is bound by the bytes of its matrix, so that is single precision: an entry is wrong by 6e-8 of its size, as is the
// force of a cell. Sums are single, too, within a run, which is short, and double from there on.
#pragma once

#include <cstddef>
#include <cstdint>

namespace robotskin::control {

// Eight columns of the matrix, by rows: force (3) and moment (3). A column that stands for no cell is zero.
struct alignas(64) WrenchBlock {
  static constexpr std::size_t columns = 8;
  float rows[6][columns];
};

// Blocks of one joint whose columns have their forces one after another.
struct WrenchRun {
  static constexpr std::size_t most_blocks = 16;
  std::uint32_t first_force;  // index of the force of the first column
  std::uint32_t block_count;
  std::uint32_t joint;
};

// wrenches (joints, 6) += matrix * force. The runs are dealt the blocks in their order; a force is read for every
// column of a block and has to be finite even where that is zero.
void add_wrenches(const WrenchRun* runs, std::size_t run_count, const WrenchBlock* blocks, const float* force,
                  double* wrenches) noexcept;

}  // namespace robotskin::control
