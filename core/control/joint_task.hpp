// Joint task: an impedance that draws every joint to its reference.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "control/control_error.hpp"

namespace robotskin::control {

struct JointGains {
  std::vector<double> stiffness;  // (n) Nm/rad
  std::vector<double> damping;    // (n) Nm s/rad, beside the friction of the torque resolver
};

// Throws ControlError unless both have `joint_count` finite values that are not negative.
inline void check_joint_gains(const JointGains& gains, std::size_t joint_count) {
  const auto check = [joint_count](const char* name, const std::vector<double>& values) {
    if (values.size() != joint_count)
      throw ControlError(std::string("joint task: ") + name + " has " + std::to_string(values.size()) +
                         " values, the robot has " + std::to_string(joint_count) + " joints");
    for (const double value : values)
      if (!std::isfinite(value) || value < 0)
        throw ControlError(std::string("joint task: ") + name + " " + std::to_string(value) +
                           " must be finite and not negative");
  };
  check("stiffness", gains.stiffness);
  check("damping", gains.damping);
}

// torque (n) = K (reference - position) - D velocity. All arrays (n); rad, rad/s, Nm.
inline void joint_task(const JointGains& gains, std::span<const double> reference, std::span<const double> position,
                       std::span<const double> velocity, std::span<double> torque) noexcept {
  for (std::size_t i = 0; i < torque.size(); ++i)
    torque[i] = gains.stiffness[i] * (reference[i] - position[i]) - gains.damping[i] * velocity[i];
}

}  // namespace robotskin::control
