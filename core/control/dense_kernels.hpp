// SPDX-License-Identifier: Apache-2.0
// Products and solves with small dense matrices, compiled for several instruction sets.
//
// Matrices are stored by columns that lie `stride` doubles apart. Nothing overlaps what is written.
#pragma once

#include <cstddef>

namespace robotskin::control {

// A (rows, columns), x (columns), y (rows): y = A x.
void product(const double* matrix, std::size_t stride, std::size_t rows, std::size_t columns, const double* x,
             double* y) noexcept;
// A (rows, columns), x (rows), y (columns): y = A^T x.
void transposed_product(const double* matrix, std::size_t stride, std::size_t rows, std::size_t columns,
                        const double* x, double* y) noexcept;
// A (rows, columns) -= x y^T.
void subtract_outer(double* matrix, std::size_t stride, std::size_t rows, std::size_t columns, const double* x,
                    const double* y) noexcept;
// a, b (count) = cosine a + sine b, cosine b - sine a.
void rotate_columns(double* a, double* b, std::size_t count, double cosine, double sine) noexcept;

// The lower triangle of a positive definite matrix (size, size) becomes its factor L, A = L L^T. False if it has none.
[[nodiscard]] bool factorise(double* matrix, std::size_t stride, std::size_t size) noexcept;
// x (size) = L^-1 x and L^-T x; what stands above the diagonal is not read.
void solve_lower(const double* factor, std::size_t stride, std::size_t size, double* x) noexcept;
void solve_lower_transposed(const double* factor, std::size_t stride, std::size_t size, double* x) noexcept;
// x (size) = R^-1 x and R^-T x; what stands below the diagonal of R is not read.
void solve_upper(const double* factor, std::size_t stride, std::size_t size, double* x) noexcept;
void solve_upper_transposed(const double* factor, std::size_t stride, std::size_t size, double* x) noexcept;
// A (rows, size) = A L^-T.
void divide_by_transposed(const double* factor, std::size_t stride, std::size_t size, double* matrix,
                          std::size_t matrix_stride, std::size_t rows) noexcept;

}  // namespace robotskin::control
