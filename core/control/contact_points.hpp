// SPDX-License-Identifier: Apache-2.0
// Where a robot is touched: the cells' forces merged into contacts, each with a force and a point of a body.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "control/touch_matrix.hpp"
#include "model/spatial.hpp"

namespace robotskin::control {

struct ContactGains {
  // Cells of a body that are nearer than this to a contact belong to it. Infinite: all contacts of a body are one, at
  // their force centroid, as in section V-E.
  double merge_within_m = 1e9;
  double bandwidth_hz = 20;  // of force and point
  double fade_s = 0.1;       // in which a contact that is over stops counting
};

// The frame is that of the joint that carries the body.
struct Contact {
  std::size_t body = 0, joint = 0;
  Vector3 force{};     // newton
  Vector3 point{};     // m, the force centroid
  double share = 0;    // 0 to 1, how much it counts; 0: there is no contact here
  bool fresh = false;  // it began in this tick

  Vector3 sum{}, moment{};  // of this tick: force, and points times magnitude
  double magnitude = 0;     // newton
};

class ContactPoints {
 public:
  static constexpr std::size_t most_of_a_body = 4;

  // Throws ControlError for gains that are not positive, and what TouchMatrix throws.
  ContactPoints(const RobotModel& robot, const skin::SkinModel& skin, const TouchMatrix& matrix, ContactGains gains);

  void reset() noexcept;
  // `magnitudes` (N) newton, what each cell asks for, as TouchWrench has them.
  void update(std::span<const float> magnitudes, double period_s) noexcept;
  // Room for every contact there can be; those whose share is 0 are none.
  std::span<const Contact> contacts() const noexcept { return contacts_; }

 private:
  struct Cell {
    std::int32_t body = -1;    // -1: on the base
    Vector3 touch{}, point{};  // of a unit touch; in the joint's frame
  };
  Contact& contact_of(const Cell& cell) noexcept;

  ContactGains gains_;
  std::vector<Cell> cells_;
  std::vector<Contact> contacts_;  // (bodies, most_of_a_body)
};

}  // namespace robotskin::control
