// The product at the heart of the skin task: a constant 6 x n matrix times n scalar forces (eq. 22, 23).
#pragma once

#include <cstddef>

namespace robotskin::control {

// wrench (6) = matrix * magnitude over `count` columns. The matrix is stored by rows that lie `stride` doubles apart.
void wrench_product(const double* matrix, std::size_t stride, const double* magnitude, std::size_t count,
                    double* wrench) noexcept;

}  // namespace robotskin::control
