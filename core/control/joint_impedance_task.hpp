// SPDX-License-Identifier: Apache-2.0
// Joint impedance task: springs and dampers towards a moving reference, on joints that keep their own inertia.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "control/joint_task.hpp"
#include "control/task.hpp"
#include "control/vector_mailbox.hpp"
#include "model/robot_model.hpp"

namespace robotskin::control {

// M a + C v + g = K (reference - q) + D (reference' - v) + C v + g + touch. The inertia and the friction that the user
// adds to every joint are taken out again, so that a light finger meets a thing as lightly as it is. A reference is a
// position and a velocity; it goes on with this velocity for `largest_age_s`, and then stands. Claims all joints.
class JointImpedanceTask final : public Task {
 public:
  // Throws ControlError for gains that do not fit the robot.
  JointImpedanceTask(const RobotModel& robot, JointGains gains);

  // From any thread; (n) rad inside of the limits and (n) rad/s, else ControlError. They take effect at once.
  void request_reference(std::span<const double> position, std::span<const double> velocity);

  void start(const TaskInput& input) noexcept override;
  [[nodiscard]] bool update(const TaskInput& input) noexcept override;
  // (n) rad of the last tick.
  std::span<const double> reference() const noexcept { return {reference_.data(), joint_count()}; }

  static constexpr double largest_age_s = 0.02;
  // Near its end a joint that is pushed there meets a spring beside its own, as many times as stiff.
  static constexpr double end_margin = 0.06;  // rad, of long ranges
  static constexpr double end_stiffness = 10;

 private:
  JointGains gains_;
  std::vector<double> lower_, upper_;           // (n)
  VectorMailbox box_;                           // (2 n)
  std::vector<double> reference_, scratch_;     // (2 n) position, then velocity
  std::vector<double> push_, acceleration_of_;  // (n)
  double age_s_ = 0;
};

}  // namespace robotskin::control
