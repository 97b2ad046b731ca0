// SPDX-License-Identifier: Apache-2.0
#include "baselines/naive_skin_task.hpp"

#include <algorithm>
#include <array>

namespace robotskin::lab {

NaiveSkinTask::NaiveSkinTask(const RobotModel& robot, const skin::SkinModel& skin)
    : skin_(skin), jacobian_(6 * robot.joint_count()) {
  for (const std::string& name : skin.link_names) link_.push_back(robot.link_index(name));
}

void NaiveSkinTask::compute(const RobotDynamics& dynamics, std::span<const float> magnitude, std::span<double> torque) {
  const std::size_t joints = dynamics.joint_count();
  std::ranges::fill(torque, 0.0);
  std::array<double, 16> base_from_link;
  for (std::size_t cell = 0; cell < skin_.size(); ++cell) {
    const std::size_t link = link_[skin_.link[cell]];
    if (!dynamics.base_from_link(link, base_from_link) || !dynamics.link_jacobian(link, jacobian_)) continue;
    const auto turned = [&](double x, double y, double z) {
      std::array<double, 3> out;
      for (std::size_t row = 0; row < 3; ++row)
        out[row] = base_from_link[4 * row] * x + base_from_link[4 * row + 1] * y + base_from_link[4 * row + 2] * z;
      return out;
    };
    const auto& rotation = skin_.link_from_cell_rotation[cell];
    const auto& translation = skin_.link_from_cell_translation[cell];
    const auto normal = turned(rotation[2], rotation[5], rotation[8]);
    const auto arm = turned(translation[0], translation[1], translation[2]);
    // [Cheng19 eq. 15]
    const std::array<double, 3> force = {-normal[0] * magnitude[cell], -normal[1] * magnitude[cell],
                                         -normal[2] * magnitude[cell]};
    for (std::size_t joint = 0; joint < joints; ++joint) {
      const auto linear = [&](std::size_t axis) { return jacobian_[axis * joints + joint]; };
      const auto angular = [&](std::size_t axis) { return jacobian_[(axis + 3) * joints + joint]; };
      // The cell's own Jacobian: the link's, shifted by omega x arm.
      // [Cheng19 eq. 16, 17]
      torque[joint] += force[0] * (linear(0) + angular(1) * arm[2] - angular(2) * arm[1]) +
                       force[1] * (linear(1) + angular(2) * arm[0] - angular(0) * arm[2]) +
                       force[2] * (linear(2) + angular(0) * arm[1] - angular(1) * arm[0]);
    }
  }
}

}  // namespace robotskin::lab
