// SPDX-License-Identifier: Apache-2.0
#include "control/self_collision_task.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "control/control_error.hpp"
#include "model/spatial.hpp"

namespace robotskin::control {

SelfCollisionTask::SelfCollisionTask(const RobotModel& robot, SelfDistance distances, SelfCollisionGains gains)
    : Task("self-collision", robot.joint_count(), SelfDistance::largest_measured),
      distances_(std::move(distances)),
      gains_(gains),
      parent_(robot.joint_parents().begin(), robot.joint_parents().end()) {
  for (const double value : {gains.safe_m, gains.stiffness, gains.damping})
    if (!(value > 0) || !std::isfinite(value))
      throw ControlError("self-collision task: gain " + std::to_string(value) + " must be finite and greater than 0");
}

bool SelfCollisionTask::update(const TaskInput& input) noexcept {
  const std::size_t joints = joint_count();
  near_ = distances_.update(input.dynamics, gains_.safe_m);
  std::ranges::fill(torque_, 0.0);
  row_count_ = 0;
  for (const NearPair& pair : near_) {
    double* row = &rows_[row_count_++ * joints];
    std::fill_n(row, joints, 0.0);
    // The rate of the distance: how point b moves along the normal, less how point a does.
    const auto add = [&](int joint, const Vector3& point, double sign) {
      for (; joint != RobotModel::base; joint = parent_[static_cast<std::size_t>(joint)]) {
        const double* motion = &input.dynamics.joint_motions()[6 * static_cast<std::size_t>(joint)];
        const Vector3 velocity = load3(motion) + cross(load3(motion + 3), point);
        row[joint] += sign * dot(pair.a_to_b, velocity);
      }
    };
    add(pair.joint_b, pair.point_b, 1);
    add(pair.joint_a, pair.point_a, -1);
    double rate = 0;
    multiply(row, 1, joints, input.velocity.data(), &rate);
    const double missing = gains_.safe_m - pair.distance_m;
    const double x = std::clamp(missing / gains_.safe_m, 0.0, 1.0);
    const double active = x * x * (3 - 2 * x);
    const double push = active * (gains_.stiffness * missing - gains_.damping * rate);
    add_transposed(row, 1, joints, &push, torque_.data());
    for (std::size_t i = 0; i < joints; ++i) row[i] *= active;
  }
  return true;
}

}  // namespace robotskin::control
