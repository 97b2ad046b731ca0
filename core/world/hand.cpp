// SPDX-License-Identifier: Apache-2.0
#include "world/hand.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>

namespace robotskin::world {
namespace {

constexpr double start_m = 0.08;       // where a new task begins, in front of the cell
constexpr double same_place_m = 0.06;  // aside by no more than this the ball goes there instead of starting anew
constexpr double park_beyond_m = 0.12;
constexpr double guide_n_per_m = 1500;  // holds the ball on the cell's normal and at its distance
constexpr double rise_s = 0.1;          // from touch to full force
constexpr double speed_max_m_s = 0.25;
constexpr double leave_speed_m_s = 0.3;
constexpr double push_damping = 15;  // N s/m towards the cell, so that a push does not bounce

}  // namespace

Hand::Hand(const mjModel& model, const HandDescription& description)
    : description_(description),
      position_address_(model.jnt_qposadr[description.joint]),
      velocity_address_(model.jnt_dofadr[description.joint]) {}

void Hand::aim(std::size_t cell, double x_m, double y_m) {
  cell_ = cell;
  x_m_ = x_m;
  y_m_ = y_m;
  fresh_aim_ = true;
}

void Hand::push(std::size_t cell, double force_n, double x_m, double y_m) {
  aim(cell, x_m, y_m);
  force_n_ = force_n;
  if (task_ != Task::pushing) ramp_n_ = 0;
  task_ = Task::pushing;
}

void Hand::approach(std::size_t cell, double distance_m, double speed_m_s, double x_m, double y_m) {
  aim(cell, x_m, y_m);
  distance_m_ = distance_m;
  speed_m_s_ = speed_m_s;
  task_ = Task::approaching;
}

void Hand::leave() {
  if (task_ != Task::parked) task_ = Task::leaving;
}

void Hand::place(mjData& data, const Vector3& position) const {
  for (int i = 0; i < 3; ++i) {
    data.qpos[position_address_ + i] = position[i];
    data.qvel[velocity_address_ + i] = 0;
  }
}

void Hand::drive(const mjModel& model, mjData& data, const Mounting& mounting, bool touching) {
  double* force = data.qfrc_applied + velocity_address_;
  force[0] = force[1] = force[2] = 0;
  if (task_ == Task::parked) return;

  const int body = mounting.cell_body[cell_];
  const Matrix3 world_from_body = load9(data.xmat + 9 * body);
  const Matrix3 rotation = multiply(world_from_body, mounting.body_from_cell_rotation[cell_]);
  const Vector3 normal = {rotation[2], rotation[5], rotation[8]};
  const Vector3 arm =
      apply(world_from_body, mounting.body_from_cell_translation[cell_]) + apply(rotation, {x_m_, y_m_, 0});
  const Vector3 aimed = load3(data.xpos + 3 * body) + arm;
  mjtNum motion[6];  // rotation first
  mj_objectVelocity(&model, &data, mjOBJ_XBODY, body, motion, 0);
  const Vector3 aimed_velocity = load3(motion + 3) + cross(load3(motion), arm);

  Vector3 offset = load3(data.qpos + position_address_) - aimed;
  double height = dot(offset, normal);
  Vector3 aside = offset - height * normal;
  if (fresh_aim_) {
    fresh_aim_ = false;
    if (norm(aside) > same_place_m || height < 0 || height > start_m + 2 * description_.radius_m) {
      offset = (start_m + description_.radius_m) * normal;
      place(data, aimed + offset);
      height = dot(offset, normal);
      aside = {0, 0, 0};
      ramp_n_ = 0;
    }
    target_m_ = height - description_.radius_m;
  }
  const double gap_m = height - description_.radius_m;
  const Vector3 velocity = load3(data.qvel + velocity_address_) - aimed_velocity;
  const double closing = -dot(velocity, normal);
  const Vector3 aside_velocity = velocity + closing * normal;

  const double critical = 2 * std::sqrt(guide_n_per_m * description_.mass_kg);
  Vector3 applied = -guide_n_per_m * aside - critical * aside_velocity;
  double inwards = 0;  // along the inward normal
  if (task_ == Task::pushing) {
    if (!touching && ramp_n_ == 0) {
      const double speed = std::min(speed_max_m_s, 0.03 + 8 * std::max(gap_m, 0.0));
      inwards = std::clamp(description_.mass_kg / 0.01 * (speed - closing), -force_n_, force_n_);
    } else {
      ramp_n_ =
          force_n_ > ramp_n_ ? std::min(force_n_, ramp_n_ + force_n_ / rise_s * model.opt.timestep + 1e-9) : force_n_;
      inwards = ramp_n_ - push_damping * closing;
    }
  } else {
    const double goal_m = task_ == Task::leaving ? 1.5 * park_beyond_m : distance_m_;
    const double speed_m_s = task_ == Task::leaving ? leave_speed_m_s : speed_m_s_;
    const double reach_m = speed_m_s * model.opt.timestep;
    target_m_ += std::clamp(goal_m - target_m_, -reach_m, reach_m);
    inwards = guide_n_per_m * (gap_m - target_m_) - critical * closing;
    if (task_ == Task::leaving && gap_m > park_beyond_m) {
      task_ = Task::parked;
      ramp_n_ = 0;
      place(data, description_.parking);
      return;
    }
  }
  applied = applied - inwards * normal;
  for (int i = 0; i < 3; ++i) force[i] = applied[i];
}

}  // namespace robotskin::world
