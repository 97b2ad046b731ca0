// SPDX-License-Identifier: Apache-2.0
#include "baselines/plain_product.hpp"

#include "control/instruction_sets.hpp"

namespace robotskin::lab {

// CMake lets the compiler reorder the sums of this file, which is what makes them vectors.
ROBOTSKIN_INSTRUCTION_SETS
void plain_product(const double* matrix, std::size_t stride, const double* magnitude, std::size_t count,
                   double* wrench) noexcept {
  const double *r0 = matrix, *r1 = r0 + stride, *r2 = r1 + stride, *r3 = r2 + stride, *r4 = r3 + stride,
               *r5 = r4 + stride;
  double w0 = 0, w1 = 0, w2 = 0, w3 = 0, w4 = 0, w5 = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double force = magnitude[i];
    w0 += r0[i] * force;
    w1 += r1[i] * force;
    w2 += r2[i] * force;
    w3 += r3[i] * force;
    w4 += r4[i] * force;
    w5 += r5[i] * force;
  }
  wrench[0] = w0;
  wrench[1] = w1;
  wrench[2] = w2;
  wrench[3] = w3;
  wrench[4] = w4;
  wrench[5] = w5;
}

}  // namespace robotskin::lab
