// SPDX-License-Identifier: Apache-2.0
// Spatial algebra in plain memory: 3-vectors, rotations, placements and Jacobians of points.
//
// A placement is a row-major 4 x 4 matrix (16 doubles): rotation and origin; it maps a point in its inner frame to its
// outer one. A Matrix3 is row-major. Nothing here allocates.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace robotskin {

using Vector3 = std::array<double, 3>;
using Matrix3 = std::array<double, 9>;

constexpr Vector3 operator+(const Vector3& a, const Vector3& b) noexcept {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
constexpr Vector3 operator-(const Vector3& a, const Vector3& b) noexcept {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
constexpr Vector3 operator*(double factor, const Vector3& a) noexcept {
  return {factor * a[0], factor * a[1], factor * a[2]};
}
constexpr double dot(const Vector3& a, const Vector3& b) noexcept {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
constexpr Vector3 cross(const Vector3& a, const Vector3& b) noexcept {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double norm(const Vector3& a) noexcept {
  return std::sqrt(dot(a, a));
}

constexpr Vector3 apply(const Matrix3& m, const Vector3& a) noexcept {
  return {m[0] * a[0] + m[1] * a[1] + m[2] * a[2], m[3] * a[0] + m[4] * a[1] + m[5] * a[2],
          m[6] * a[0] + m[7] * a[1] + m[8] * a[2]};
}
constexpr Vector3 apply_transposed(const Matrix3& m, const Vector3& a) noexcept {
  return {m[0] * a[0] + m[3] * a[1] + m[6] * a[2], m[1] * a[0] + m[4] * a[1] + m[7] * a[2],
          m[2] * a[0] + m[5] * a[1] + m[8] * a[2]};
}
constexpr Matrix3 multiply(const Matrix3& a, const Matrix3& b) noexcept {
  Matrix3 c{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      c[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
  return c;
}
constexpr Vector3 load3(const double* p) noexcept {
  return {p[0], p[1], p[2]};
}
constexpr Matrix3 load9(const double* p) noexcept {
  return {p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8]};
}

// Turns by the length of `turn`, rad, about its direction (Rodrigues).
inline Matrix3 rotation_about(const Vector3& turn) noexcept {
  const double angle = norm(turn);
  if (angle == 0) return {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const Vector3 k = (1 / angle) * turn;
  const double c = std::cos(angle), s = std::sin(angle), v = 1 - c;
  return {c + v * k[0] * k[0],        v * k[0] * k[1] - s * k[2], v * k[0] * k[2] + s * k[1],
          v * k[0] * k[1] + s * k[2], c + v * k[1] * k[1],        v * k[1] * k[2] - s * k[0],
          v * k[0] * k[2] - s * k[1], v * k[1] * k[2] + s * k[0], c + v * k[2] * k[2]};
}

// The upper left of a row-major 4 x 4 placement times v.
inline Vector3 rotate(const double* placement, const Vector3& v) noexcept {
  Vector3 out;
  for (std::size_t row = 0; row < 3; ++row)
    out[row] = placement[4 * row] * v[0] + placement[4 * row + 1] * v[1] + placement[4 * row + 2] * v[2];
  return out;
}
inline Vector3 origin_of(const double* placement) noexcept {
  return {placement[3], placement[7], placement[11]};
}
inline Vector3 place(const double* placement, const Vector3& v) noexcept {
  return rotate(placement, v) + origin_of(placement);
}
// The inverse: from a point outside to the same point inside.
inline Vector3 place_back(const double* placement, const Vector3& v) noexcept {
  const Vector3 arm = v - origin_of(placement);
  Vector3 out;
  for (std::size_t column = 0; column < 3; ++column)
    out[column] = placement[column] * arm[0] + placement[4 + column] * arm[1] + placement[8 + column] * arm[2];
  return out;
}

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

// The rotation vector (rad, base frame) that turns the orientation of `from` into that of `to`, both 4 x 4; at most pi
// long, and of any sign at exactly pi.
inline Vector3 rotation_between(const double* from, const double* to) noexcept {
  double turn[9];  // to from^T
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 3; ++column) {
      double entry = 0;
      for (std::size_t i = 0; i < 3; ++i) entry += to[4 * row + i] * from[4 * column + i];
      turn[3 * row + column] = entry;
    }
  const Vector3 axial = {turn[7] - turn[5], turn[2] - turn[6], turn[3] - turn[1]};  // 2 sin(angle) axis
  const double sine = 0.5 * norm(axial);
  const double cosine = 0.5 * (turn[0] + turn[4] + turn[8] - 1);
  const double angle = std::atan2(sine, cosine);
  if (sine > 1e-6) return (0.5 * angle / sine) * axial;
  if (cosine > 0) return 0.5 * axial;
  // Half a turn: the axis is the longest column of turn + 1.
  std::size_t longest = 0;
  for (std::size_t i = 1; i < 3; ++i)
    if (turn[4 * i] > turn[4 * longest]) longest = i;
  Vector3 axis = {turn[longest], turn[3 + longest], turn[6 + longest]};
  axis[longest] += 1;
  return (angle / norm(axis)) * axis;
}

// The row-major placement whose orientation is `from`'s turned by the rotation vector (rad, base frame) `turn`, and
// whose origin is `origin`. The arrays (16) may not overlap.
inline void turned_placement(const double* from, const Vector3& turn, const Vector3& origin, double* out) noexcept {
  const double angle = norm(turn);
  const Vector3 axis = angle > 1e-12 ? (1 / angle) * turn : Vector3{1, 0, 0};
  for (std::size_t column = 0; column < 3; ++column) {
    const Vector3 old = {from[column], from[4 + column], from[8 + column]};
    const Vector3 across = cross(axis, old);
    const double along = dot(axis, old) * (1 - std::cos(angle));
    for (std::size_t row = 0; row < 3; ++row)
      out[4 * row + column] = old[row] * std::cos(angle) + across[row] * std::sin(angle) + axis[row] * along;
  }
  for (std::size_t row = 0; row < 3; ++row) out[4 * row + 3] = origin[row];
  out[12] = out[13] = out[14] = 0;
  out[15] = 1;
}

// Turns a link's Jacobian (6, n), which is that of its origin, into that of the point `arm` away from the origin, both
// along the axes of the base.
inline void shift_jacobian(const Vector3& arm, std::size_t joints, double* jacobian) noexcept {
  double* x = jacobian;
  double *y = x + joints, *z = y + joints, *u = z + joints, *v = u + joints, *w = v + joints;
  for (std::size_t i = 0; i < joints; ++i) {
    x[i] += v[i] * arm[2] - w[i] * arm[1];
    y[i] += w[i] * arm[0] - u[i] * arm[2];
    z[i] += u[i] * arm[1] - v[i] * arm[0];
  }
}

// torque (n) += rows^T force, rows (count, n).
inline void add_transposed(const double* rows, std::size_t count, std::size_t joints, const double* force,
                           double* torque) noexcept {
  for (std::size_t row = 0; row < count; ++row)
    for (std::size_t i = 0; i < joints; ++i) torque[i] += rows[row * joints + i] * force[row];
}

// out (count) = rows vector, rows (count, n).
inline void multiply(const double* rows, std::size_t count, std::size_t joints, const double* vector,
                     double* out) noexcept {
  for (std::size_t row = 0; row < count; ++row) {
    double entry = 0;
    for (std::size_t i = 0; i < joints; ++i) entry += rows[row * joints + i] * vector[i];
    out[row] = entry;
  }
}

}  // namespace robotskin
