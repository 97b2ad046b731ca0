// SPDX-License-Identifier: Apache-2.0
#include "skin/torque_reader.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace robotskin::skin {

TorqueReader::TorqueReader(driver::SnapshotTable<driver::LimbTorque>& torques, std::vector<LimbPlace> limbs,
                           std::size_t joints, const TorqueReaderOptions& options)
    : torques_(torques), limbs_(std::move(limbs)), newest_(limbs_.size()), joints_(joints), options_(options) {
  for (const LimbPlace& limb : limbs_) {
    if (limb.joints.empty() || limb.joints.size() > driver::torque_joints_max)
      throw std::invalid_argument("limb " + std::to_string(limb.limb) + " has " + std::to_string(limb.joints.size()) +
                                  " joints: 1 to " + std::to_string(driver::torque_joints_max) + " can be");
    for (const std::size_t joint : limb.joints) {
      if (joint >= joints)
        throw std::invalid_argument("limb " + std::to_string(limb.limb) + " names joint " + std::to_string(joint) +
                                    ": the robot has " + std::to_string(joints));
    }
  }
}

void TorqueReader::read(std::int64_t now_ns, SkinTorque& torque) {
  torque.joint.assign(joints_, 0.0);
  torque.stamp_ns = now_ns;
  torque.cells = torque.active = 0;
  torque.saturated = false;
  torque.fresh = !limbs_.empty();
  const auto is_old = [&](const driver::LimbTorque& row) {
    return row.heard_ns == 0 || now_ns - row.epoch_ns > options_.fresh_ns;
  };
  const auto rows = torques_.read();
  for (std::size_t i = 0; i < limbs_.size(); ++i) {
    const auto row = std::ranges::find_if(rows, [&](const driver::LimbTorque& candidate) {
      return candidate.heard_ns != 0 && candidate.group == limbs_[i].group && candidate.limb == limbs_[i].limb;
    });
    driver::LimbTorque& newest = newest_[i];
    if (row != rows.end() && (row->whole || is_old(newest))) newest = *row;
    if (is_old(newest)) {
      torque.fresh = false;
      continue;
    }
    for (std::size_t k = 0; k < limbs_[i].joints.size(); ++k) {
      torque.joint[limbs_[i].joints[k]] += newest.joint[k] * options_.step;
    }
    torque.stamp_ns = std::min(torque.stamp_ns, newest.epoch_ns);
    torque.cells += newest.cells[0];
    torque.active += newest.active;
    torque.saturated |= newest.saturated;
  }
  if (!torque.fresh) std::ranges::fill(torque.joint, 0.0);
}

}  // namespace robotskin::skin
