// SPDX-License-Identifier: Apache-2.0
#include "control/dense_kernels.hpp"

#include <cmath>

#include "control/instruction_sets.hpp"

// CMake lets the compiler reorder the sums of this file, which is what makes them vectors.
namespace robotskin::control {
namespace {

// y -= A x, four columns at a time, so that y is read and written as rarely.
inline void subtract_product(const double* __restrict matrix, std::size_t stride, std::size_t rows, std::size_t columns,
                             const double* __restrict x, std::size_t x_stride, double* __restrict y) {
  std::size_t k = 0;
  for (; k + 4 <= columns; k += 4) {
    const double* __restrict a = matrix + k * stride;
    const double x0 = x[k * x_stride], x1 = x[(k + 1) * x_stride], x2 = x[(k + 2) * x_stride],
                 x3 = x[(k + 3) * x_stride];
    for (std::size_t i = 0; i < rows; ++i)
      y[i] -= a[i] * x0 + a[i + stride] * x1 + a[i + 2 * stride] * x2 + a[i + 3 * stride] * x3;
  }
  for (; k < columns; ++k) {
    const double* __restrict a = matrix + k * stride;
    const double one = x[k * x_stride];
    for (std::size_t i = 0; i < rows; ++i) y[i] -= a[i] * one;
  }
}

}  // namespace

ROBOTSKIN_INSTRUCTION_SETS
void product(const double* matrix, std::size_t stride, std::size_t rows, std::size_t columns, const double* x,
             double* y) noexcept {
  for (std::size_t i = 0; i < rows; ++i) y[i] = 0;
  std::size_t k = 0;
  for (; k + 4 <= columns; k += 4) {
    const double* __restrict a = matrix + k * stride;
    double* __restrict out = y;
    const double x0 = x[k], x1 = x[k + 1], x2 = x[k + 2], x3 = x[k + 3];
    for (std::size_t i = 0; i < rows; ++i)
      out[i] += a[i] * x0 + a[i + stride] * x1 + a[i + 2 * stride] * x2 + a[i + 3 * stride] * x3;
  }
  for (; k < columns; ++k) {
    const double* __restrict a = matrix + k * stride;
    double* __restrict out = y;
    const double one = x[k];
    for (std::size_t i = 0; i < rows; ++i) out[i] += a[i] * one;
  }
}

ROBOTSKIN_INSTRUCTION_SETS
void transposed_product(const double* matrix, std::size_t stride, std::size_t rows, std::size_t columns,
                        const double* x, double* y) noexcept {
  std::size_t k = 0;
  for (; k + 4 <= columns; k += 4) {
    const double* a = matrix + k * stride;
    double y0 = 0, y1 = 0, y2 = 0, y3 = 0;
    for (std::size_t i = 0; i < rows; ++i) {
      y0 += a[i] * x[i];
      y1 += a[i + stride] * x[i];
      y2 += a[i + 2 * stride] * x[i];
      y3 += a[i + 3 * stride] * x[i];
    }
    y[k] = y0;
    y[k + 1] = y1;
    y[k + 2] = y2;
    y[k + 3] = y3;
  }
  for (; k < columns; ++k) {
    const double* a = matrix + k * stride;
    double sum = 0;
    for (std::size_t i = 0; i < rows; ++i) sum += a[i] * x[i];
    y[k] = sum;
  }
}

ROBOTSKIN_INSTRUCTION_SETS
void subtract_outer(double* matrix, std::size_t stride, std::size_t rows, std::size_t columns, const double* x,
                    const double* y) noexcept {
  for (std::size_t k = 0; k < columns; ++k) {
    double* __restrict a = matrix + k * stride;
    const double* __restrict in = x;
    const double one = y[k];
    for (std::size_t i = 0; i < rows; ++i) a[i] -= in[i] * one;
  }
}

ROBOTSKIN_INSTRUCTION_SETS
void rotate_columns(double* a, double* b, std::size_t count, double cosine, double sine) noexcept {
  double* __restrict first = a;
  double* __restrict second = b;
  for (std::size_t i = 0; i < count; ++i) {
    const double old = first[i];
    first[i] = cosine * old + sine * second[i];
    second[i] = cosine * second[i] - sine * old;
  }
}

ROBOTSKIN_INSTRUCTION_SETS
bool factorise(double* matrix, std::size_t stride, std::size_t size) noexcept {
  for (std::size_t k = 0; k < size; ++k) {
    double* column = matrix + k * stride;
    subtract_product(matrix + k, stride, size - k, k, matrix + k, stride, column + k);
    if (!(column[k] > 0)) return false;
    const double root = std::sqrt(column[k]), inverse = 1 / root;
    column[k] = root;
    for (std::size_t i = k + 1; i < size; ++i) column[i] *= inverse;
  }
  return true;
}

ROBOTSKIN_INSTRUCTION_SETS
void solve_lower(const double* factor, std::size_t stride, std::size_t size, double* x) noexcept {
  double* __restrict out = x;
  for (std::size_t k = 0; k < size; ++k) {
    const double* __restrict column = factor + k * stride;
    const double one = out[k] / column[k];
    out[k] = one;
    for (std::size_t i = k + 1; i < size; ++i) out[i] -= column[i] * one;
  }
}

ROBOTSKIN_INSTRUCTION_SETS
void solve_lower_transposed(const double* factor, std::size_t stride, std::size_t size, double* x) noexcept {
  for (std::size_t k = size; k-- > 0;) {
    const double* column = factor + k * stride;
    double sum = 0;
    for (std::size_t i = k + 1; i < size; ++i) sum += column[i] * x[i];
    x[k] = (x[k] - sum) / column[k];
  }
}

ROBOTSKIN_INSTRUCTION_SETS
void solve_upper(const double* factor, std::size_t stride, std::size_t size, double* x) noexcept {
  double* __restrict out = x;
  for (std::size_t k = size; k-- > 0;) {
    const double* __restrict column = factor + k * stride;
    const double one = out[k] / column[k];
    out[k] = one;
    for (std::size_t i = 0; i < k; ++i) out[i] -= column[i] * one;
  }
}

ROBOTSKIN_INSTRUCTION_SETS
void solve_upper_transposed(const double* factor, std::size_t stride, std::size_t size, double* x) noexcept {
  for (std::size_t k = 0; k < size; ++k) {
    const double* column = factor + k * stride;
    double sum = 0;
    for (std::size_t i = 0; i < k; ++i) sum += column[i] * x[i];
    x[k] = (x[k] - sum) / column[k];
  }
}

ROBOTSKIN_INSTRUCTION_SETS
void divide_by_transposed(const double* factor, std::size_t stride, std::size_t size, double* matrix,
                          std::size_t matrix_stride, std::size_t rows) noexcept {
  for (std::size_t k = 0; k < size; ++k) {
    double* __restrict column = matrix + k * matrix_stride;
    subtract_product(matrix, matrix_stride, rows, k, factor + k, stride, column);
    const double inverse = 1 / factor[k + k * stride];
    for (std::size_t i = 0; i < rows; ++i) column[i] *= inverse;
  }
}

}  // namespace robotskin::control
