// SPDX-License-Identifier: Apache-2.0
#include "skin/datagram_input.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "robotskin/fixed_point.h"

namespace robotskin::skin {
namespace {

constexpr std::int64_t turn = RS_TURN;

std::int16_t code_of(JointCode::Kind kind, double position) noexcept {
  if (kind == JointCode::Kind::none || !std::isfinite(position)) return 0;
  if (kind == JointCode::Kind::slide)
    return static_cast<std::int16_t>(std::clamp(std::nearbyint(position * (1 << RS_LENGTH_BITS)), -32768.0, 32767.0));
  // Turns beyond the range of the counts are taken off, so that the same angle has the same code.
  const double counts = std::nearbyint(position / (2 * std::numbers::pi) * static_cast<double>(turn));
  const auto wrapped = static_cast<std::int64_t>(std::fmod(counts, static_cast<double>(turn)));
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(wrapped & (turn - 1)));
}

}  // namespace

void DatagramInput::take_skin_computed_torque(driver::Driver& driver, TorqueReader& torques,
                                              std::vector<LimbCodes> limbs, std::size_t joint_count) {
  for (const LimbCodes& limb : limbs) {
    if (limb.joints.empty() || limb.joints.size() > driver::LimbJoints{}.position.size())
      throw std::invalid_argument("limb " + std::to_string(limb.limb) + " has " + std::to_string(limb.joints.size()) +
                                  " joints: 1 to " + std::to_string(driver::LimbJoints{}.position.size()) + " can be");
    for (const JointCode& code : limb.joints)
      if (code.joint >= joint_count)
        throw std::invalid_argument("limb " + std::to_string(limb.limb) + ": joint " + std::to_string(code.joint) +
                                    ", the robot has 0 to " + std::to_string(joint_count - 1));
  }
  driver_ = &driver;
  torques_ = &torques;
  limbs_ = std::move(limbs);
  skin_computed_torque_ = SkinTorque(joint_count);
}

InputStatus DatagramInput::read(std::int64_t now_ns, SkinState& state) noexcept {
  const std::int64_t before_ns = state.time_ns;
  reader_.read(now_ns, state);
  if (torques_ != nullptr) torques_->read(now_ns, skin_computed_torque_);
  return state.time_ns != before_ns ? InputStatus::ok : InputStatus::nothing_new;
}

void DatagramInput::tell_joints(std::int64_t now_ns, std::span<const double> position) noexcept {
  if (driver_ == nullptr || !telling_ || position.size() != skin_computed_torque_.joint.size()) return;
  for (const LimbCodes& limb : limbs_) {
    driver::LimbJoints told{.set_ns = now_ns,
                            .group = limb.group,
                            .limb = limb.limb,
                            .joints = static_cast<std::uint8_t>(limb.joints.size()),
                            .position = {}};
    for (std::size_t i = 0; i < limb.joints.size(); ++i)
      told.position[i] = code_of(limb.joints[i].kind, position[limb.joints[i].joint]);
    (void)driver_->joints(told);  // a limb that does not fit is one that the cells were never told of
  }
}

}  // namespace robotskin::skin
