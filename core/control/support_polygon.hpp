// SPDX-License-Identifier: Apache-2.0
// The support polygon: the convex hull of what stands on the floor.
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace robotskin::control {

using Vector2 = std::array<double, 2>;

// Metres, on a level floor. Room for two soles of four corners each.
class SupportPolygon {
 public:
  static constexpr std::size_t most = 8;

  // The hull of up to `most` points; what is more is not looked at.
  void set(std::span<const Vector2> points) noexcept;
  // Corners, anticlockwise.
  std::span<const Vector2> corners() const noexcept { return {corners_.data(), count_}; }
  Vector2 centre() const noexcept;  // of its area

  // How far inside the nearest edge a point is; negative: outside of it. Of a hull with fewer than three corners:
  // -infinity.
  double inside_by(const Vector2& point) const noexcept;
  // The point nearest to this one that is inside by at least `margin`, as far as there is any.
  Vector2 clipped(Vector2 point, double margin) const noexcept;

 private:
  std::array<Vector2, most> corners_{};
  std::size_t count_ = 0;
};

}  // namespace robotskin::control
