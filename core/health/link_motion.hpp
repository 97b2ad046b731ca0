// SPDX-License-Identifier: Apache-2.0
// What an accelerometer anywhere on a link should feel, from the joints alone.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "model/robot_dynamics.hpp"

namespace robotskin::health {

// Of one link, in its own frame: at r (metres) the specific force is origin + gradient r, in m/s^2.
struct LinkForce {
  std::array<double, 3> origin{};    // acceleration of the link's origin minus gravity
  std::array<double, 9> gradient{};  // row-major, 1/s^2: angular acceleration and centripetal part
};

// Accelerations are differences of velocities over one update, behind a low-pass; so they are late by about its time.
class LinkMotion {
 public:
  // Links by name. Throws ModelError for a link that the robot does not have.
  LinkMotion(const RobotModel& robot, const std::vector<std::string>& links, double period_s = 0.004,
             double low_pass_s = 0.02);

  // Of the joints at `now_ns`: n positions and velocities. Before a period has passed nothing changes. False, and
  // nothing changes, for wrong counts or what is no number.
  bool update(std::int64_t now_ns, std::span<const double> position, std::span<const double> velocity) noexcept;

  bool known() const noexcept { return known_; }
  const LinkForce& link(std::size_t index) const noexcept { return force_[index]; }

 private:
  struct Last {
    std::array<double, 3> velocity{}, turn{};           // base frame, of the link's origin
    std::array<double, 3> acceleration{}, turn_rate{};  // behind the low-pass
  };

  RobotDynamics dynamics_;
  std::vector<std::size_t> links_;
  std::vector<double> jacobian_, pose_;
  std::vector<Last> last_;
  std::vector<LinkForce> force_;
  std::int64_t period_ns_, last_ns_ = 0;
  double low_pass_s_;
  int updates_ = 0;
  bool known_ = false;
};

}  // namespace robotskin::health
