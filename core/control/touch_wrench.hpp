// SPDX-License-Identifier: Apache-2.0
// The touch wrench: what a touch does to each body of the robot, and the joint torques that follow from it [Cheng19
// eq. 14 to 17], at the cost of one small product a body [Cheng19 eq. 22 to 25]. No task itself: tasks of touch are
// given one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "control/skin_activation.hpp"
#include "control/touch_matrix.hpp"
#include "model/robot_dynamics.hpp"
#include "model/spatial.hpp"
#include "skin/skin_state.hpp"

namespace robotskin::control {

struct TaskInput;

// Force in newton, and moment in Nm about the base's origin, both along the axes of the base.
struct Wrench {
  Vector3 force, moment;
};

// Tasks that ask for the same touch share one object, which computes it once a tick, whichever task asks first.
class TouchWrench {
 public:
  // Throws ModelError for a link the robot does not have, ControlError for gains that do not fit the skin.
  TouchWrench(const RobotModel& robot, const skin::SkinModel& skin, const SkinGains& gains)
      : TouchWrench(std::make_shared<const TouchMatrix>(robot, skin), gains) {}
  // The matrix may be shared by touches of other gains. Throws ControlError.
  TouchWrench(std::shared_ptr<const TouchMatrix> matrix, const SkinGains& gains);

  const TouchMatrix& matrix() const noexcept { return *matrix_; }
  const std::shared_ptr<const TouchMatrix>& shared_matrix() const noexcept { return matrix_; }
  std::size_t cell_count() const noexcept { return matrix_->cell_count(); }
  std::size_t joint_count() const noexcept { return matrix_->joint_count(); }

  // Everything below at the posture of the last update of dynamics. `share` (N) 0 to 1: 0 masks a cell. False, with
  // zero torque, if the state or the share does not have N cells or the dynamics n joints.
  [[nodiscard]] bool compute(const RobotDynamics& dynamics, const skin::SkinState& state,
                             std::span<const float> share) noexcept;
  // The same for the tick of a task; computed only by the first call of a tick.
  [[nodiscard]] bool update(const TaskInput& input) noexcept;

  // (n) Nm J^T W of all cells [Cheng19 eq. 17, 25].
  std::span<const double> torque() const noexcept { return torque_; }
  // (N) newton, what each cell asks for, in the order of the skin model [Cheng19 eq. 14].
  std::span<const float> magnitudes() const noexcept { return std::span(magnitude_).first(cell_count()); }
  // (n, 6) force and moment about the joint's origin, in the joint's frame, of the cells of each joint's body
  // [Cheng19 eq. 23].
  std::span<const double> joint_wrenches() const noexcept { return joint_wrench_; }
  // Of one body with cells, turned to the base [Cheng19 eq. 24].
  const Wrench& wrench(std::size_t body) const noexcept { return body_wrench_[body]; }
  // torque (n) = factor J^T of the body's wrench.
  void body_torque(const RobotDynamics& dynamics, std::size_t body, double factor, double* torque) const noexcept;

 private:
  std::shared_ptr<const TouchMatrix> matrix_;
  SkinActivation activation_;
  skin::CellArray<float> magnitude_, sorted_;
  std::vector<double> joint_wrench_;    // (n, 6)
  std::vector<Wrench> body_wrench_;     // (bodies)
  std::vector<double> subtree_wrench_;  // (n, 6) about the base's origin, in the base frame
  std::vector<double> torque_;          // (n)
  const RobotDynamics* last_dynamics_ = nullptr;
  std::uint64_t last_tick_ = 0;
  bool last_valid_ = false;
};

// Throws ControlError, naming the task, for a touch of a robot with another number of joints.
void require_joints(const TouchWrench& touch, const RobotModel& robot, const std::string& task);

// Share of a claim that a force of this size makes: 0 without touch, without a step or a kink to 1.
inline double touch_share(double force_n) noexcept {
  constexpr double half_n = 1.0;
  return force_n * force_n / (force_n * force_n + half_n * half_n);
}

}  // namespace robotskin::control
