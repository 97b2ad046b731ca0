// SPDX-License-Identifier: Apache-2.0
// Joint task whose reference moves to each goal along a quintic.
#pragma once

#include <vector>

#include "control/joint_task.hpp"
#include "control/quintic.hpp"

namespace robotskin::control {

// No joint moves faster than `speed`; a goal on the way is taken up without a jump in position, velocity or
// acceleration.
class SplineJointTask final : public JointTask {
 public:
  // speed in rad/s, > 0.
  SplineJointTask(const RobotModel& robot, JointGains gains, double speed);

  void start(const TaskInput& input) noexcept override;
  bool arrived() const noexcept { return time_s_ >= duration_s_; }

 protected:
  void follow(const TaskInput& input, bool fresh) noexcept override;

 private:
  double speed_;
  double time_s_ = 0, duration_s_ = 0;
  std::vector<Quintic> splines_;  // (n)
};

}  // namespace robotskin::control
