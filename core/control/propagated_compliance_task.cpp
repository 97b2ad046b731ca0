// SPDX-License-Identifier: Apache-2.0
#include "control/propagated_compliance_task.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "control/acceleration_bounds.hpp"
#include "control/control_error.hpp"

namespace robotskin::control {
namespace {

// Of joints that belong to no limb, rad/s^2.
constexpr double usual_acceleration = 10;
// Of a joint's velocity limit; the rest is for the guard.
constexpr double part_of_speed = 0.95;
// On which stopping before a position limit counts, rad/s^2 or m/s^2: less than the guard has, which may brake later.
constexpr double braking = 5;
// In which the desired motion of a contact that cannot follow loses the speed that it has more.
constexpr double catch_up_s = 0.05;

void check(const PropagationGains& gains) {
  const auto require = [](const char* name, double value, bool zero) {
    if (!std::isfinite(value) || value < 0 || (value == 0 && !zero))
      throw ControlError(std::string("propagated compliance task: ") + name + " " + std::to_string(value) +
                         " must be finite and " + (zero ? "not negative" : "greater than 0"));
  };
  require("inertia", gains.impedance.inertia, false);
  require("damping", gains.impedance.damping, true);
  require("stiffness", gains.impedance.stiffness, true);
  require("largest_speed_m_s", gains.largest_speed_m_s, false);
  require("largest_joint_speed", gains.largest_joint_speed, false);
  require("largest_lead_m", gains.largest_lead_m, false);
  require("tracking_per_s", gains.tracking_per_s, false);
  require("effort", gains.effort, false);
  require("kept_m_s2", gains.kept_m_s2, true);
  require("return_per_s", gains.return_per_s, true);
  require("begin_s", gains.begin_s, true);
}

Vector3 shortened(const Vector3& vector, double longest) noexcept {
  const double length = norm(vector);
  return length > longest ? (longest / length) * vector : vector;
}

}  // namespace

PropagatedComplianceTask::PropagatedComplianceTask(const RobotModel& robot, const skin::SkinModel& skin,
                                                   std::shared_ptr<TouchWrench> touch, const std::vector<Limb>& limbs,
                                                   PropagationGains gains)
    : Task("propagated compliance", robot.joint_count(),
           3 * ContactPoints::most_of_a_body * touch->matrix().body_count()),
      touch_(std::move(touch)),
      gains_(gains),
      limits_(QuadraticLimits::of(robot, braking)),
      points_(robot, skin, touch_->matrix(), gains.contacts),
      motions_(points_.contacts().size()),
      reference_dynamics_(robot),
      reference_(robot.joint_count()),
      largest_(robot.joint_count(), usual_acceleration),
      begins_(gains.begin_s) {
  check(gains);
  require_joints(*touch_, robot, name());
  const std::size_t joints = joint_count(), rows = largest_rows();
  for (double& velocity : limits_.velocity) velocity = std::min(part_of_speed * velocity, gains.largest_joint_speed);
  std::vector<LimbJoints> indexed = indexed_limbs(robot, limbs);
  double most = 0;
  for (const LimbJoints& limb : indexed) most = std::max(most, *std::ranges::max_element(limb.largest_acceleration));
  for (LimbJoints& limb : indexed) {
    for (std::size_t i = 0; i < limb.joints.size(); ++i) largest_[limb.joints[i]] = limb.largest_acceleration[i];
    programmes_.emplace_back(std::move(limb), rows, gains.effort, most);
  }
  const TouchMatrix& matrix = touch_->matrix();
  leaf_.assign(matrix.body_count(), LimbJoints::no_parent);
  for (std::size_t body = 0; body < leaf_.size(); ++body)
    for (std::size_t limb = 0; limb < programmes_.size(); ++limb)  // parents come first, so the last is the outermost
      if (std::ranges::any_of(programmes_[limb].limb().joints,
                              [&](std::size_t joint) { return matrix.carried_by(body, joint); }))
        leaf_[body] = limb;
  for (auto* values : {&velocity6_, &drift6_}) values->resize(6 * joints);
  for (auto* values : {&low_, &high_, &free_, &acceleration_}) values->resize(joints);
  active_.reserve(motions_.size());
  jacobian_.resize(rows * joints);
  residual_.resize(rows);
  limb_jacobian_.resize(rows * joints);
  limb_residual_.resize(rows);
  limb_mass_.resize(joints * joints);
  limb_values_.resize(7 * joints);
  residuals_.resize(programmes_.size());
}

void PropagatedComplianceTask::start(const TaskInput& input) noexcept {
  points_.reset();
  begins_.set(0);
  for (std::size_t i = 0; i < joint_count(); ++i)
    reference_[i] = std::clamp(input.position[i], limits_.lower[i], limits_.upper[i]);
  std::ranges::fill(acceleration_, 0.0);
  (void)reference_dynamics_.update(reference_, acceleration_);  // both are finite
}

// Velocity of each joint's body, and its acceleration where no joint accelerates, about the origin of the base.
void PropagatedComplianceTask::follow_bodies(const TaskInput& input) noexcept {
  const std::span<const int> parents = touch_->matrix().joint_parents();
  const std::span<const double> motions = input.dynamics.joint_motions();
  for (std::size_t i = 0; i < joint_count(); ++i) {
    Vector3 linear{}, angular{}, drift{}, turn{};
    if (parents[i] != RobotModel::base) {
      const std::size_t parent = 6 * static_cast<std::size_t>(parents[i]);
      linear = load3(&velocity6_[parent]);
      angular = load3(&velocity6_[parent + 3]);
      drift = load3(&drift6_[parent]);
      turn = load3(&drift6_[parent + 3]);
    }
    const Vector3 own = load3(&motions[6 * i]), own_turn = load3(&motions[6 * i + 3]);
    drift = drift + input.velocity[i] * (cross(angular, own) + cross(linear, own_turn));
    turn = turn + input.velocity[i] * cross(angular, own_turn);
    std::ranges::copy(linear + input.velocity[i] * own, &velocity6_[6 * i]);
    std::ranges::copy(angular + input.velocity[i] * own_turn, &velocity6_[6 * i + 3]);
    std::ranges::copy(drift, &drift6_[6 * i]);
    std::ranges::copy(turn, &drift6_[6 * i + 3]);
  }
}

// Back to the reference, critically damped, as far as limits allow.
void PropagatedComplianceTask::set_free_accelerations(const TaskInput& input) noexcept {
  const double rate = gains_.return_per_s;
  for (std::size_t i = 0; i < joint_count(); ++i) {
    const double position = input.position[i], velocity = input.velocity[i];
    const AccelerationBounds bounds = acceleration_bounds({limits_.lower[i], limits_.upper[i], limits_.velocity[i],
                                                           limits_.braking[i], limits_.margin_rad, limits_.horizon_s},
                                                          position, velocity);
    // A joint that has to brake harder than it is to accelerate may do so.
    low_[i] = std::min(std::max(bounds.low, -largest_[i]), bounds.high);
    high_[i] = std::max(std::min(bounds.high, largest_[i]), bounds.low);
    const double wanted = rate * rate * (reference_[i] - position) - 2 * rate * velocity;
    acceleration_[i] = free_[i] = std::clamp(wanted, low_[i], high_[i]);
  }
}

// What the contact is to accelerate by: [Cheng19 eq. 26], and back to its motion where it has left it.
Vector3 PropagatedComplianceTask::asked(const Contact& contact, Motion& motion, const Vector3& reference,
                                        const Vector3& point, const Vector3& velocity, const double* base_from_joint,
                                        double period_s) const noexcept {
  const ContactImpedanceGains& impedance = gains_.impedance;
  const Vector3 force = rotate(base_from_joint, contact.force);
  // [Cheng19 eq. 26]
  const Vector3 desired =
      (1 / impedance.inertia) * (force - impedance.damping * motion.velocity - impedance.stiffness * motion.moved);
  motion.velocity = shortened(motion.velocity + period_s * desired, gains_.largest_speed_m_s);
  motion.moved = motion.moved + period_s * motion.velocity;
  Vector3 behind = reference + motion.moved - point;
  if (norm(behind) > gains_.largest_lead_m) {
    behind = shortened(behind, gains_.largest_lead_m);
    motion.moved = point + behind - reference;
    motion.velocity = motion.velocity + (period_s / (period_s + catch_up_s)) * (velocity - motion.velocity);
  }
  const double rate = gains_.tracking_per_s;
  return desired + 2 * rate * (motion.velocity - velocity) + rate * rate * behind;
}

void PropagatedComplianceTask::add_contact(const TaskInput& input, std::size_t index) noexcept {
  const Contact& contact = points_.contacts()[index];
  Motion& motion = motions_[index];
  const std::size_t joints = joint_count(), joint = contact.joint;
  const double* base_from_joint = &input.dynamics.base_from_joint()[16 * joint];
  const double* reference_from_joint = &reference_dynamics_.base_from_joint()[16 * joint];
  const Vector3 point = place(base_from_joint, contact.point);
  const Vector3 reference = place(reference_from_joint, contact.point);
  const Vector3 angular = load3(&velocity6_[6 * joint + 3]);
  const Vector3 velocity = load3(&velocity6_[6 * joint]) + cross(angular, point);
  if (contact.fresh) {
    motion = {.moved = point - reference, .velocity = velocity};
  } else {
    // The centroid wanders on the body as cells come and go; how far it is behind its motion stays.
    motion.moved = motion.moved + (point - reference) -
                   (place(base_from_joint, motion.point) - place(reference_from_joint, motion.point));
  }
  motion.point = contact.point;
  const Vector3 wanted = asked(contact, motion, reference, point, velocity, base_from_joint, input.period_s);
  Vector3 left =
      wanted - (load3(&drift6_[6 * joint]) + cross(load3(&drift6_[6 * joint + 3]), point) + cross(angular, velocity));
  double* rows = &jacobian_[3 * active_.size() * joints];
  for (std::size_t i = 0; i < joints; ++i) {
    Vector3 column{};
    if (touch_->matrix().carried_by(contact.body, i)) {
      const double* axis = &input.dynamics.joint_motions()[6 * i];
      column = load3(axis) + cross(load3(axis + 3), point);
    }
    for (std::size_t row = 0; row < 3; ++row) rows[row * joints + i] = contact.share * column[row];
    left = left - acceleration_[i] * column;
  }
  for (std::size_t row = 0; row < 3; ++row) residual_[3 * active_.size() + row] = contact.share * begun_ * left[row];
  active_.push_back(index);
}

bool PropagatedComplianceTask::update(const TaskInput& input) noexcept {
  if (!touch_->update(input)) return false;
  const std::size_t joints = joint_count();
  follow_bodies(input);
  set_free_accelerations(input);
  points_.update(touch_->magnitudes(), input.period_s);
  begun_ = begins_.step(true, input.period_s);
  active_.clear();
  for (std::size_t i = 0; i < motions_.size(); ++i)
    if (points_.contacts()[i].share > 0) add_contact(input, i);
  std::ranges::fill(residuals_, 0.0);
  StepBudget budget{.most = gains_.steps, .deadline_ns = input.deadline_ns};
  for (std::size_t sweep = 0; sweep < gains_.sweeps && !active_.empty(); ++sweep)
    for (std::size_t limb = programmes_.size(); limb-- > 0;)
      if (!solve(input, limb, budget)) return false;
  cut_by_clock_ = budget.by_clock;
  cut_ = cut_by_clock_ || (budget.most > 0 && budget.taken == budget.most);

  const bool own = !input.mass.empty();
  const std::span<const double> mass = own ? input.mass : input.dynamics.mass_matrix();
  const std::span<const double> bias = own ? input.bias : input.dynamics.nonlinear_effects();
  for (std::size_t row = 0; row < joints; ++row) {
    torque_[row] = bias[row] - input.dynamics.gravity_torque()[row];
    for (std::size_t i = 0; i < joints; ++i) torque_[row] += mass[row * joints + i] * acceleration_[i];
  }
  row_count_ = 3 * active_.size();
  std::copy_n(jacobian_.begin(), row_count_ * joints, rows_.begin());
  return true;
}

// The programme of a limb for all contacts on it and on what it carries, whose residual comes from the limbs beyond.
bool PropagatedComplianceTask::solve(const TaskInput& input, std::size_t limb, StepBudget& budget) noexcept {
  LimbProgramme& programme = programmes_[limb];
  const std::vector<std::size_t>& own = programme.limb().joints;
  const std::size_t joints = joint_count(), count = own.size();
  const auto takes_part = [&](std::size_t index) {
    std::size_t one = leaf_[points_.contacts()[index].body];
    while (one != LimbJoints::no_parent && one != limb) one = programmes_[one].limb().parent;
    return one == limb;
  };
  std::size_t rows = 0;
  for (std::size_t k = 0; k < active_.size(); ++k) {
    const Contact& contact = points_.contacts()[active_[k]];
    if (!takes_part(active_[k])) continue;
    // As a whole vector less so much: what is handed on begins at 0, and has no step.
    const double kept = leaf_[contact.body] == limb ? 0 : contact.share * gains_.kept_m_s2;
    const double taken = 1 - kept / std::max(norm(load3(&residual_[3 * k])), std::max(kept, 1e-12));
    for (std::size_t row = 3 * k; row < 3 * k + 3; ++row, ++rows) {
      limb_residual_[rows] = taken * residual_[row];
      for (std::size_t i = 0; i < count; ++i) limb_jacobian_[rows * count + i] = jacobian_[row * joints + own[i]];
    }
  }
  if (rows == 0) return true;
  double *so_far = limb_values_.data(), *changed = so_far + count, *low = changed + count, *high = low + count,
         *torque = high + count, *largest = torque + count, *change = largest + count;
  const std::span<const double> mass = input.dynamics.mass_matrix();
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t joint = own[i];
    so_far[i] = acceleration_[joint];
    changed[i] = acceleration_[joint] - free_[joint];
    low[i] = low_[joint];
    high[i] = high_[joint];
    largest[i] = limits_.torque[joint];
    torque[i] = input.dynamics.nonlinear_effects()[joint];
    for (std::size_t k = 0; k < joints; ++k) torque[i] += mass[joint * joints + k] * acceleration_[k];
    for (std::size_t k = 0; k < count; ++k) limb_mass_[i * count + k] = mass[joint * joints + own[k]];
  }
  const LimbState state{.acceleration = {so_far, count},
                        .changed = {changed, count},
                        .low = {low, count},
                        .high = {high, count},
                        .mass = {limb_mass_.data(), count * count},
                        .torque = {torque, count},
                        .largest_torque = {largest, count}};
  if (!programme.solve(state, {limb_jacobian_.data(), rows * count}, {limb_residual_.data(), rows}, budget,
                       {change, count}))
    return false;
  for (std::size_t i = 0; i < count; ++i) acceleration_[own[i]] += change[i];
  rows = 0;
  double squared = 0;
  for (std::size_t k = 0; k < active_.size(); ++k) {
    if (!takes_part(active_[k])) continue;
    for (std::size_t row = 3 * k; row < 3 * k + 3; ++row, ++rows) {
      for (std::size_t i = 0; i < count; ++i) residual_[row] -= jacobian_[row * joints + own[i]] * change[i];
      squared += residual_[row] * residual_[row];
    }
  }
  residuals_[limb] = std::sqrt(squared);
  return true;
}

}  // namespace robotskin::control
