// SPDX-License-Identifier: Apache-2.0
// Touch moves a frame of the robot's choice, wherever the limb is touched.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "control/low_pass.hpp"
#include "control/task.hpp"
#include "control/touch_wrench.hpp"
#include "model/robot_model.hpp"

namespace robotskin::control {

// Every touch of a limb moves the frame of one of its links: torque = J_v^T F, F the sum of the cells' forces in the
// base frame and J_v the frame's translation. The limb is what lies between the base and the link, and what the link
// carries; cells elsewhere do nothing. Claims 3 rows.
class SkinCartesianTask final : public Task {
 public:
  // Throws ModelError for an unknown link, ControlError for a link on the base or a touch of another robot.
  SkinCartesianTask(const RobotModel& robot, std::shared_ptr<TouchWrench> touch, const std::string& link,
                    double bandwidth_hz = 0, double period_s = 0.001);
  void start(const TaskInput&) noexcept override { filter_.prime(); }
  [[nodiscard]] bool update(const TaskInput& input) noexcept override;
  const Vector3& force() const noexcept { return force_; }  // newton, base frame, before the filter

 private:
  std::shared_ptr<TouchWrench> touch_;
  LowPass filter_;
  std::size_t link_;
  std::vector<bool> limb_;  // (bodies)
  Vector3 force_{};
  std::vector<double> jacobian_;  // (6, n)
};

}  // namespace robotskin::control
