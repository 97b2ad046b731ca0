// SPDX-License-Identifier: Apache-2.0
// Inner velocity loop: keeps the real robot on the virtual one against what the model does not know, such as friction.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace robotskin::control {

// The released controller used proportional 3 /s, integral proportional^2 / 4 (critical damping), derivative 0 and
// a dead zone of 0.002 rad/s.
struct InnerLoopGains {
  std::vector<double> proportional;  // (n) 1/s on the position error
  std::vector<double> integral;      // (n) 1/s^2 on its integral
  std::vector<double> derivative;    // (n) 1 on the velocity error, < 1
  double dead_zone_rad_s = 0.002;    // velocity errors below it are none
  double estimator_hz = 20;          // below it the velocity estimate follows the real robot, above it the virtual one
  double largest_bias = 0.05;        // rad/s, bound of the integral's share
};

// Joint velocity estimator E(virtual velocity, real velocity): the virtual velocity, whose fast part is free of noise,
// corrected by the slow part of what the real robot does differently.
class VelocityEstimator {
 public:
  explicit VelocityEstimator(std::size_t joint_count) : difference_(joint_count) {}
  void reset(std::size_t joint) noexcept { difference_[joint] = 0; }
  double step(std::size_t joint, double virtual_velocity, double real_velocity, double bandwidth_hz,
              double period_s) noexcept {
    const double share = 1 - std::exp(-2 * M_PI * bandwidth_hz * period_s);
    difference_[joint] += share * (real_velocity - virtual_velocity - difference_[joint]);
    return virtual_velocity + difference_[joint];
  }

 private:
  std::vector<double> difference_;  // (n) rad/s, real minus virtual, slow part
};

class InnerVelocityLoop {
 public:
  InnerVelocityLoop(InnerLoopGains gains, std::size_t joint_count)
      : gains_(std::move(gains)), estimator_(joint_count), bias_(joint_count) {}

  void reset(std::size_t joint) noexcept {
    estimator_.reset(joint);
    bias_[joint] = 0;
  }

  // Commanded rad/s = virtual velocity + P e + I int(e) + D (virtual velocity - E), e = virtual - real position.
  double step(std::size_t joint, double error, double virtual_velocity, double real_velocity,
              double period_s) noexcept {
    const double estimate = estimator_.step(joint, virtual_velocity, real_velocity, gains_.estimator_hz, period_s);
    double velocity_error = virtual_velocity - estimate;
    if (std::abs(velocity_error) < gains_.dead_zone_rad_s) velocity_error = 0;
    bias_[joint] =
        std::clamp(bias_[joint] + gains_.integral[joint] * error * period_s, -gains_.largest_bias, gains_.largest_bias);
    return virtual_velocity + gains_.proportional[joint] * error + bias_[joint] +
           gains_.derivative[joint] * velocity_error;
  }

  const InnerLoopGains& gains() const noexcept { return gains_; }

 private:
  InnerLoopGains gains_;
  VelocityEstimator estimator_;
  std::vector<double> bias_;  // (n) rad/s
};

}  // namespace robotskin::control
