// SPDX-License-Identifier: Apache-2.0
#include "control/contact_impedance_task.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "control/control_error.hpp"

namespace robotskin::control {
namespace {

constexpr double least_force_n = 1e-3;
// 1/kg below which a direction of the contact counts as one that the arm cannot move in.
constexpr double singular = 1e-3;

// solution = matrix^-1 right_side for a symmetric positive definite 3 x 3 matrix.
Vector3 solve(const double (&m)[3][3], const Vector3& b) noexcept {
  const Vector3 r0 = {m[0][0], m[0][1], m[0][2]}, r1 = {m[1][0], m[1][1], m[1][2]}, r2 = {m[2][0], m[2][1], m[2][2]};
  const Vector3 c0 = cross(r1, r2), c1 = cross(r2, r0), c2 = cross(r0, r1);
  const double determinant = dot(r0, c0);
  return (1 / determinant) * (b[0] * c0 + b[1] * c1 + b[2] * c2);
}

}  // namespace

ContactImpedanceTask::ContactImpedanceTask(std::shared_ptr<TouchWrench> touch, ContactImpedanceGains gains)
    : Task("contact impedance", touch->joint_count(), 3 * touch->matrix().body_count()),
      touch_(std::move(touch)),
      gains_(gains),
      contacts_(touch_->matrix().body_count()),
      jacobian_(3 * joint_count()),
      response_(3 * joint_count()) {
  for (const double value : {gains.inertia, gains.damping, gains.stiffness})
    if (!std::isfinite(value) || value < 0)
      throw ControlError("contact impedance task: gain " + std::to_string(value) + " must be finite and not negative");
  if (gains.inertia == 0) throw ControlError("contact impedance task: inertia 0 must be greater than 0");
}

void ContactImpedanceTask::start(const TaskInput&) noexcept {
  for (Contact& contact : contacts_) contact.touched = false;
}

bool ContactImpedanceTask::update(const TaskInput& input) noexcept {
  if (!touch_->update(input)) return false;
  std::ranges::fill(torque_, 0.0);
  row_count_ = 0;
  for (std::size_t body = 0; body < contacts_.size(); ++body)
    if (!add(input, body)) return false;
  return true;
}

bool ContactImpedanceTask::add(const TaskInput& input, std::size_t body) noexcept {
  const std::size_t joints = joint_count();
  const TouchMatrix& matrix = touch_->matrix();
  const Wrench& wrench = touch_->wrench(body);
  const double force = norm(wrench.force);
  Contact& contact = contacts_[body];
  if (force < least_force_n) {
    contact.touched = false;
    return true;
  }
  const double* base_from_joint = &input.dynamics.base_from_joint()[16 * matrix.body_joint(body)];
  if (!contact.touched) {
    contact.touched = true;
    std::copy_n(base_from_joint, 16, contact.base_from_joint.begin());
  }
  // The point of the wrench's axis that lies nearest to the joint's origin: r = F x M / F^2 about that origin.
  const Vector3 about_joint = wrench.moment - cross(origin_of(base_from_joint), wrench.force);
  const Vector3 arm = (1 / (force * force)) * cross(wrench.force, about_joint);
  const Vector3 point = origin_of(base_from_joint) + arm;

  double *x = jacobian_.data(), *y = x + joints, *z = y + joints;
  for (std::size_t i = 0; i < joints; ++i) {
    Vector3 column = {};
    if (matrix.carried_by(body, i)) {
      const double* motion = &input.dynamics.joint_motions()[6 * i];
      column = load3(motion) + cross(load3(motion + 3), point);
    }
    x[i] = column[0];
    y[i] = column[1];
    z[i] = column[2];
  }
  double mobility[3][3];  // J M^-1 J^T, 1/kg
  for (std::size_t row = 0; row < 3; ++row) {
    const std::span<double> response(&response_[row * joints], joints);
    if (!input.dynamics.solve_mass({&jacobian_[row * joints], joints}, response)) return false;
    multiply(jacobian_.data(), 3, joints, response.data(), mobility[row]);
  }
  // (A A + d^2) f = A a is the damped solution of A f = a.
  double squared[3][3];
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 3; ++column) {
      squared[row][column] = row == column ? singular * singular : 0.0;
      for (std::size_t i = 0; i < 3; ++i) squared[row][column] += mobility[row][i] * mobility[i][column];
    }
  std::array<double, 3> velocity;
  multiply(jacobian_.data(), 3, joints, input.velocity.data(), velocity.data());
  const Vector3 rest = place(contact.base_from_joint.data(), place_back(base_from_joint, point));
  const Vector3 moved = point - rest;
  const double share = touch_share(force);
  Vector3 asked;  // x'' of [Cheng19 eq. 26], m/s^2
  for (std::size_t axis = 0; axis < 3; ++axis)
    asked[axis] = share * (wrench.force[axis] - gains_.damping * velocity[axis] - gains_.stiffness * moved[axis]) /
                  gains_.inertia;
  Vector3 turned = {};
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 3; ++column) turned[row] += mobility[row][column] * asked[column];
  const Vector3 push = solve(squared, turned);
  add_transposed(jacobian_.data(), 3, joints, push.data(), torque_.data());
  for (std::size_t i = 0; i < 3 * joints; ++i) rows_[row_count_ * joints + i] = share * jacobian_[i];
  row_count_ += 3;
  return true;
}

}  // namespace robotskin::control
