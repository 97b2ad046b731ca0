// SPDX-License-Identifier: Apache-2.0
// Cartesian task whose reference moves to each goal along a line by a quintic.
#pragma once

#include <array>
#include <string>

#include "control/cartesian_task.hpp"
#include "control/quintic.hpp"
#include "model/spatial.hpp"

namespace robotskin::control {

// Position and orientation move together, along a straight line and about one axis, by one quintic. A new goal under
// way begins from the reference's place and velocity along the new line, its other velocity is dropped.
class SplineCartesianTask final : public CartesianTask {
 public:
  // speed in m/s and turn_speed in rad/s, > 0.
  SplineCartesianTask(const RobotModel& robot, const std::string& link, CartesianGains gains, double speed,
                      double turn_speed);

  void start(const TaskInput& input) noexcept override;
  bool arrived() const noexcept { return time_s_ >= duration_s_; }

 protected:
  void follow(const TaskInput& input, bool fresh) noexcept override;

 private:
  double speed_, turn_speed_;
  double time_s_ = 0, duration_s_ = 0;
  Quintic share_;  // 0 to 1 of the way
  std::array<double, 16> begin_{};
  Vector3 way_{}, turn_{};  // m, rad, base frame
};

}  // namespace robotskin::control
