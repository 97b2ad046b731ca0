// SPDX-License-Identifier: Apache-2.0
// The bare product of a 6 x n matrix in double precision with n numbers: the yardstick of the skin task's time.
#pragma once

#include <cstddef>

namespace robotskin::lab {

// wrench (6) = matrix * magnitude. The matrix is stored by rows that lie `stride` doubles apart.
void plain_product(const double* matrix, std::size_t stride, const double* magnitude, std::size_t count,
                   double* wrench) noexcept;

}  // namespace robotskin::lab
