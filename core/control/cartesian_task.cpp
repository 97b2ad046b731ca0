// SPDX-License-Identifier: Apache-2.0
#include "control/cartesian_task.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "control/control_error.hpp"
#include "model/spatial.hpp"

namespace robotskin::control {
namespace {

void check_gains(const std::string& task, const char* name, const std::array<double, 6>& values) {
  for (const double value : values)
    if (!std::isfinite(value) || value < 0)
      throw ControlError(task + " task: " + name + " " + std::to_string(value) + " must be finite and not negative");
}

// How far the upper left is from a rotation.
double rotation_defect(const double* placement) {
  double worst = 0;
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b) {
      double entry = a == b ? -1 : 0;
      for (std::size_t row = 0; row < 3; ++row) entry += placement[4 * row + a] * placement[4 * row + b];
      worst = std::max(worst, std::abs(entry));
    }
  const Vector3 x = {placement[0], placement[4], placement[8]}, y = {placement[1], placement[5], placement[9]},
                z = {placement[2], placement[6], placement[10]};
  return std::max(worst, std::abs(dot(cross(x, y), z) - 1));
}

}  // namespace

CartesianTask::CartesianTask(const RobotModel& robot, const std::string& link, CartesianGains gains, std::string name)
    : Task(std::move(name), robot.joint_count(), 6),
      link_(robot.link_index(link)),
      gains_(gains),
      goal_box_(16),
      jacobian_(6 * robot.joint_count()) {
  if (robot.link_joints()[link_] == RobotModel::base)
    throw ControlError(this->name() + " task: link '" + link + "' is part of the base, which does not move");
  check_gains(this->name(), "stiffness", gains.stiffness);
  check_gains(this->name(), "damping", gains.damping);
}

void CartesianTask::request_reference(std::span<const double> base_from_link) {
  if (base_from_link.size() != 16)
    throw ControlError(name() + " task: the reference has " + std::to_string(base_from_link.size()) +
                       " numbers, a pose has 16");
  for (const double value : base_from_link)
    if (!std::isfinite(value)) throw ControlError(name() + " task: the reference is not finite");
  const double defect = rotation_defect(base_from_link.data());
  if (defect > 1e-6) throw ControlError(name() + " task: the reference's rotation is off by " + std::to_string(defect));
  goal_box_.post(base_from_link);
}

void CartesianTask::start(const TaskInput& input) noexcept {
  (void)input.dynamics.base_from_link(link_, reference_);
  goal_ = reference_;
  reference_velocity_.fill(0);
}

void CartesianTask::follow(const TaskInput&, bool fresh) noexcept {
  if (fresh) reference_ = goal_;
}

bool CartesianTask::update(const TaskInput& input) noexcept {
  const std::size_t joints = joint_count();
  if (input.held) goal_box_.drop();
  follow(input, !input.held && goal_box_.take(goal_, scratch_));
  std::array<double, 16> pose;
  if (!input.dynamics.base_from_link(link_, pose) || !input.dynamics.link_jacobian(link_, jacobian_)) return false;

  const Vector3 gap = origin_of(reference_.data()) - origin_of(pose.data());
  const Vector3 turn = rotation_between(pose.data(), reference_.data());
  std::array<double, 6> velocity, force;
  multiply(jacobian_.data(), 6, joints, input.velocity.data(), velocity.data());
  row_count_ = 0;
  for (std::size_t axis = 0; axis < 6; ++axis) {
    error_[axis] = axis < 3 ? gap[axis] : turn[axis - 3];
    force[axis] =
        gains_.stiffness[axis] * error_[axis] + gains_.damping[axis] * (reference_velocity_[axis] - velocity[axis]);
    if (gains_.stiffness[axis] == 0 && gains_.damping[axis] == 0) continue;
    std::copy_n(&jacobian_[axis * joints], joints, &rows_[row_count_++ * joints]);
  }
  std::ranges::fill(torque_, 0.0);
  add_transposed(jacobian_.data(), 6, joints, force.data(), torque_.data());
  return true;
}

}  // namespace robotskin::control
