// SPDX-License-Identifier: Apache-2.0
#include "control/support_polygon.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace robotskin::control {
namespace {

double turn(const Vector2& a, const Vector2& b, const Vector2& c) noexcept {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

// Distance of a point from the line through a and b, positive to its left, which is inside.
double left_of(const Vector2& a, const Vector2& b, const Vector2& point) noexcept {
  return turn(a, b, point) / std::hypot(b[0] - a[0], b[1] - a[1]);
}

}  // namespace

// Andrew's monotone chain.
void SupportPolygon::set(std::span<const Vector2> points) noexcept {
  std::array<Vector2, most> sorted{};
  const std::size_t given = std::min(points.size(), most);
  std::copy_n(points.begin(), given, sorted.begin());
  std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(given));
  std::array<Vector2, 2 * most> hull{};
  std::size_t size = 0;
  const auto add = [&](const Vector2& point, std::size_t keep) {
    while (size >= keep + 2 && turn(hull[size - 2], hull[size - 1], point) <= 0) --size;
    hull[size++] = point;
  };
  for (std::size_t i = 0; i < given; ++i) add(sorted[i], 0);
  const std::size_t lower = size > 0 ? size - 1 : 0;
  for (std::size_t i = given; i-- > 1;) add(sorted[i - 1], lower);
  count_ = size > 1 ? size - 1 : size;
  std::copy_n(hull.begin(), count_, corners_.begin());
}

// Of the area, so that corners that lie on an edge count for nothing.
Vector2 SupportPolygon::centre() const noexcept {
  if (count_ == 0) return {};
  Vector2 sum{};
  double area = 0;
  for (std::size_t i = 1; i + 1 < count_; ++i) {
    const double part = turn(corners_[0], corners_[i], corners_[i + 1]);
    area += part;
    for (std::size_t axis = 0; axis < 2; ++axis)
      sum[axis] += part * (corners_[0][axis] + corners_[i][axis] + corners_[i + 1][axis]) / 3;
  }
  return area > 0 ? Vector2{sum[0] / area, sum[1] / area} : corners_[0];
}

double SupportPolygon::inside_by(const Vector2& point) const noexcept {
  if (count_ < 3) return -std::numeric_limits<double>::infinity();
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count_; ++i)
    least = std::min(least, left_of(corners_[i], corners_[(i + 1) % count_], point));
  return least;
}

Vector2 SupportPolygon::clipped(Vector2 point, double margin) const noexcept {
  if (count_ < 3) return point;
  // Each pass moves the point onto the edges that it is beyond; where two meet in a sharp corner a few are needed.
  for (int pass = 0; pass < 8; ++pass) {
    bool moved = false;
    for (std::size_t i = 0; i < count_; ++i) {
      const Vector2 &a = corners_[i], &b = corners_[(i + 1) % count_];
      const double missing = margin - left_of(a, b, point);
      if (missing <= 1e-12) continue;
      const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
      point[0] -= missing * (b[1] - a[1]) / length;
      point[1] += missing * (b[0] - a[0]) / length;
      moved = true;
    }
    if (!moved) break;
  }
  return point;
}

}  // namespace robotskin::control
