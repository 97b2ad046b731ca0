// SPDX-License-Identifier: Apache-2.0
// The reference of the spline tasks: the polynomial of fifth degree that is continuous up to the acceleration.
#pragma once

#include <algorithm>
#include <cmath>

namespace robotskin::control {

// From any motion to rest at a goal: x(0), x'(0), x''(0) given, x(T) = goal, x'(T) = x''(T) = 0.
class Quintic {
 public:
  void set(double position, double velocity, double acceleration, double goal, double duration_s) noexcept {
    const double t = duration_s, gap = goal - position;
    duration_ = t;
    c_[0] = position;
    c_[1] = velocity;
    c_[2] = acceleration / 2;
    c_[3] = (20 * gap - 12 * velocity * t - 3 * acceleration * t * t) / (2 * t * t * t);
    c_[4] = (-30 * gap + 16 * velocity * t + 3 * acceleration * t * t) / (2 * t * t * t * t);
    c_[5] = (12 * gap - 6 * velocity * t - acceleration * t * t) / (2 * t * t * t * t * t);
    goal_ = goal;
  }
  void hold(double position) noexcept { set(position, 0, 0, position, 1); }

  double position(double t) const noexcept {
    if (t >= duration_) return goal_;
    return c_[0] + t * (c_[1] + t * (c_[2] + t * (c_[3] + t * (c_[4] + t * c_[5]))));
  }
  double velocity(double t) const noexcept {
    if (t >= duration_) return 0;
    return c_[1] + t * (2 * c_[2] + t * (3 * c_[3] + t * (4 * c_[4] + t * 5 * c_[5])));
  }
  double acceleration(double t) const noexcept {
    if (t >= duration_) return 0;
    return 2 * c_[2] + t * (6 * c_[3] + t * (12 * c_[4] + t * 20 * c_[5]));
  }

  // The shortest time in which rest to rest over `distance` keeps to the speed: the peak speed is 15/8 of the mean.
  static double duration_for(double distance, double speed) noexcept {
    return std::max(1.875 * std::abs(distance) / speed, 0.05);
  }

 private:
  double c_[6] = {};
  double duration_ = 1, goal_ = 0;
};

}  // namespace robotskin::control
