#include "control/touched_bodies.hpp"

#include <algorithm>

namespace robotskin::control {

TouchedBodies::TouchedBodies(const RobotModel& robot, const skin::SkinModel& skin) : joint_count_(robot.joint_count()) {
  std::vector<bool> worn(joint_count_, false);
  for (std::size_t cell = 0; cell < skin.size(); ++cell) {
    const int joint = robot.link_joints()[robot.link_index(skin.link_names[skin.link[cell]])];
    if (joint != RobotModel::base) worn[static_cast<std::size_t>(joint)] = true;
  }
  for (std::size_t joint = 0; joint < joint_count_; ++joint) {
    if (!worn[joint]) continue;
    joint_.push_back(joint);
    carried_.resize(carried_.size() + joint_count_, 0);
    for (int i = static_cast<int>(joint); i != RobotModel::base; i = robot.joint_parents()[i])
      carried_[carried_.size() - joint_count_ + static_cast<std::size_t>(i)] = 1;
  }
}

TouchedBodies::Wrench TouchedBodies::wrench(const RobotDynamics& dynamics, std::span<const double> joint_wrenches,
                                            std::size_t body) const noexcept {
  const double* base_from_joint = &dynamics.base_from_joint()[16 * joint_[body]];
  const double* own = &joint_wrenches[6 * joint_[body]];
  const Vector3 force = rotate(base_from_joint, {own[0], own[1], own[2]});
  const Vector3 moment = rotate(base_from_joint, {own[3], own[4], own[5]});
  return {force, sum(moment, cross(origin_of(base_from_joint), force))};
}

void TouchedBodies::torque(const RobotDynamics& dynamics, std::size_t body, const Wrench& wrench, double factor,
                           double* torque) const noexcept {
  for (std::size_t i = 0; i < joint_count_; ++i) {
    if (!carried_by(body, i)) {
      torque[i] = 0;
      continue;
    }
    const double* motion = &dynamics.joint_motions()[6 * i];
    torque[i] = factor * (dot({motion[0], motion[1], motion[2]}, wrench.force) +
                          dot({motion[3], motion[4], motion[5]}, wrench.moment));
  }
}

}  // namespace robotskin::control
