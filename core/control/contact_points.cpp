// SPDX-License-Identifier: Apache-2.0
#include "control/contact_points.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "control/control_error.hpp"
#include "control/low_pass.hpp"
#include "control/touch_wrench.hpp"

namespace robotskin::control {
namespace {

constexpr double least_share = 1e-4;

}  // namespace

ContactPoints::ContactPoints(const RobotModel& robot, const skin::SkinModel& skin, const TouchMatrix& matrix,
                             ContactGains gains)
    : gains_(gains), cells_(skin.size()), contacts_(matrix.body_count() * most_of_a_body) {
  for (const double value : {gains.merge_within_m, gains.bandwidth_hz, gains.fade_s})
    if (!(value > 0)) throw ControlError("contact points: gain " + std::to_string(value) + " must be greater than 0");
  std::vector<std::int32_t> body_of(robot.joint_count(), -1);
  for (std::size_t body = 0; body < matrix.body_count(); ++body) {
    body_of[matrix.body_joint(body)] = static_cast<std::int32_t>(body);
    for (std::size_t i = 0; i < most_of_a_body; ++i) {
      contacts_[body * most_of_a_body + i].body = body;
      contacts_[body * most_of_a_body + i].joint = matrix.body_joint(body);
    }
  }
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const std::size_t link = robot.link_index(skin.link_names[static_cast<std::size_t>(skin.link[i])]);
    const int joint = robot.link_joints()[link];
    if (joint == RobotModel::base) continue;
    const double* joint_from_link = &robot.joint_from_link()[16 * link];
    const Matrix3& turn = skin.link_from_cell_rotation[i];
    cells_[i] = {body_of[static_cast<std::size_t>(joint)], rotate(joint_from_link, {-turn[2], -turn[5], -turn[8]}),
                 place(joint_from_link, skin.link_from_cell_translation[i])};
  }
}

void ContactPoints::reset() noexcept {
  for (Contact& contact : contacts_) {
    contact.share = 0;
    contact.force = {};
  }
}

// The nearest of its body, or a new one where none is near enough.
Contact& ContactPoints::contact_of(const Cell& cell) noexcept {
  Contact* const first = &contacts_[static_cast<std::size_t>(cell.body) * most_of_a_body];
  Contact *nearest = nullptr, *room = nullptr;
  double least = 0;
  for (Contact* one = first; one != first + most_of_a_body; ++one) {
    if (one->share == 0 && one->magnitude == 0) {
      if (room == nullptr) room = one;
      continue;
    }
    const double distance = norm(one->point - cell.point);
    if (nearest == nullptr || distance < least) {
      nearest = one;
      least = distance;
    }
  }
  if (nearest != nullptr && (least < gains_.merge_within_m || room == nullptr)) return *nearest;
  room->point = cell.point;
  room->fresh = true;
  return *room;
}

void ContactPoints::update(std::span<const float> magnitudes, double period_s) noexcept {
  for (Contact& contact : contacts_) {
    contact.sum = contact.moment = {};
    contact.magnitude = 0;
    contact.fresh = false;
  }
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const double magnitude = magnitudes[i];
    if (!(magnitude > 0) || cells_[i].body < 0) continue;
    Contact& contact = contact_of(cells_[i]);
    contact.magnitude += magnitude;
    contact.sum = contact.sum + magnitude * cells_[i].touch;
    contact.moment = contact.moment + magnitude * cells_[i].point;
  }
  const double follow = low_pass_share(gains_.bandwidth_hz, period_s);
  const double fade = 1 - std::exp(-3 * period_s / gains_.fade_s);  // 95 % of the way within fade_s
  for (Contact& contact : contacts_) {
    if (contact.share == 0 && contact.magnitude == 0) continue;
    contact.force = contact.force + follow * (contact.sum - contact.force);
    if (contact.magnitude > 0) {
      const Vector3 centroid = (1 / contact.magnitude) * contact.moment;
      contact.point = contact.point + (contact.fresh ? 1.0 : follow) * (centroid - contact.point);
    }
    const double wanted = touch_share(norm(contact.force));
    contact.share += (wanted > contact.share ? follow : fade) * (wanted - contact.share);
    if (contact.magnitude == 0 && contact.share < least_share) {
      contact.share = 0;
      contact.force = {};
    }
  }
}

}  // namespace robotskin::control
