// SPDX-License-Identifier: Apache-2.0
// A hand: a ball that finds its way to a cell and pushes it with a force, or holds itself at a distance from it.
#pragma once

#include <cstddef>

#include "world/mounting.hpp"

namespace robotskin::world {

// The ball hangs on three sliding joints along the axes of the world and weighs nothing.
struct HandDescription {
  int body;
  int joint;  // the first of its three sliding joints
  double radius_m;
  double mass_kg;
  Vector3 parking;  // metres, world frame, where it disturbs nothing
};

class Hand {
 public:
  enum class Task { parked, approaching, pushing, leaving };

  Hand(const mjModel_& model, const HandDescription& description);

  // Both aim at the point (x, y), metres, of a cell's face, and follow that point when the link moves.
  // Pushes with `force_n` >= 0 along the inward normal, after coming near with at most 0.25 m/s.
  void push(std::size_t cell, double force_n, double x_m, double y_m);
  // Holds the ball's surface `distance_m` >= 0 in front of the face and gets there with at most `speed_m_s`.
  void approach(std::size_t cell, double distance_m, double speed_m_s, double x_m, double y_m);
  // Goes back along the normal and then parks.
  void leave();

  Task task() const { return task_; }
  std::size_t cell() const { return cell_; }
  const HandDescription& description() const { return description_; }

  // Between the two halves of a physics step: drives the ball. `touching`: it met a cell in the step before.
  void drive(const mjModel_& model, mjData_& data, const Mounting& mounting, bool touching);

 private:
  void aim(std::size_t cell, double x_m, double y_m);
  void place(mjData_& data, const Vector3& position) const;

  HandDescription description_;
  int position_address_, velocity_address_;
  Task task_ = Task::parked;
  bool fresh_aim_ = false;
  std::size_t cell_ = 0;
  double x_m_ = 0, y_m_ = 0;
  double force_n_ = 0, distance_m_ = 0, speed_m_s_ = 0;
  double ramp_n_ = 0;    // force reached so far
  double target_m_ = 0;  // distance reached so far
};

}  // namespace robotskin::world
