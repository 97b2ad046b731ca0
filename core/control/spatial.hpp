// Vectors, placements and Jacobians of points in plain memory.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "model/robot_dynamics.hpp"

namespace robotskin::control {

using Vector3 = std::array<double, 3>;

inline double dot(const Vector3& a, const Vector3& b) noexcept {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline double norm(const Vector3& a) noexcept {
  return std::sqrt(dot(a, a));
}
inline Vector3 cross(const Vector3& a, const Vector3& b) noexcept {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Vector3 sum(const Vector3& a, const Vector3& b) noexcept {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Vector3 difference(const Vector3& a, const Vector3& b) noexcept {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Vector3 scaled(const Vector3& a, double factor) noexcept {
  return {factor * a[0], factor * a[1], factor * a[2]};
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
  return sum(rotate(placement, v), origin_of(placement));
}
// The inverse: from a point outside to the same point inside.
inline Vector3 place_back(const double* placement, const Vector3& v) noexcept {
  const Vector3 arm = difference(v, origin_of(placement));
  Vector3 out;
  for (std::size_t column = 0; column < 3; ++column)
    out[column] = placement[column] * arm[0] + placement[4 + column] * arm[1] + placement[8 + column] * arm[2];
  return out;
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
  if (sine > 1e-6) return scaled(axial, 0.5 * angle / sine);
  if (cosine > 0) return scaled(axial, 0.5);
  // Half a turn: the axis is the longest column of turn + 1.
  std::size_t longest = 0;
  for (std::size_t i = 1; i < 3; ++i)
    if (turn[4 * i] > turn[4 * longest]) longest = i;
  Vector3 axis = {turn[longest], turn[3 + longest], turn[6 + longest]};
  axis[longest] += 1;
  return scaled(axis, angle / norm(axis));
}

// The row-major placement whose orientation is `from`'s turned by the rotation vector (rad, base frame) `turn`, and
// whose origin is `origin`. The arrays (16) may not overlap.
inline void turned_placement(const double* from, const Vector3& turn, const Vector3& origin, double* out) noexcept {
  const double angle = norm(turn);
  const Vector3 axis = angle > 1e-12 ? scaled(turn, 1 / angle) : Vector3{1, 0, 0};
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

}  // namespace robotskin::control
