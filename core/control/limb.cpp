// SPDX-License-Identifier: Apache-2.0
#include "control/limb.hpp"

#include <algorithm>
#include <cmath>

#include "control/control_error.hpp"

namespace robotskin::control {
namespace {

bool carries(const RobotModel& robot, const LimbJoints& parent, const LimbJoints& limb) {
  const auto above = [&](int joint) { return robot.joint_parents()[static_cast<std::size_t>(joint)]; };
  for (const std::size_t joint : limb.joints)
    for (int one = above(static_cast<int>(joint)); one != RobotModel::base; one = above(one))
      if (std::ranges::count(parent.joints, static_cast<std::size_t>(one)) > 0) return true;
  return false;
}

std::string names_of(const std::vector<LimbJoints>& limbs) {
  std::string names;
  for (const LimbJoints& limb : limbs) names += (names.empty() ? "" : ", ") + limb.name;
  return names.empty() ? "none" : names;
}

}  // namespace

std::vector<LimbJoints> indexed_limbs(const RobotModel& robot, const std::vector<Limb>& limbs) {
  if (limbs.empty()) throw ControlError("limbs of " + robot.name() + ": there are none");
  std::vector<LimbJoints> found;
  std::vector<std::string> taken(robot.joint_count());
  for (const Limb& limb : limbs) {
    const std::string what = "limb '" + limb.name + "' of " + robot.name();
    if (std::ranges::any_of(found, [&](const LimbJoints& one) { return one.name == limb.name; }))
      throw ControlError(what + " is there twice");
    if (limb.joints.empty()) throw ControlError(what + " has no joints");
    LimbJoints one{.name = limb.name, .largest_acceleration = limb.largest_acceleration};
    for (const std::string& name : limb.joints) {
      const std::size_t joint = robot.joint_index(name);
      if (!taken[joint].empty())
        throw ControlError(what + ": joint " + name + " belongs to limb '" + taken[joint] + "' already");
      taken[joint] = limb.name;
      one.joints.push_back(joint);
    }
    if (one.largest_acceleration.size() != one.joints.size())
      throw ControlError(what + ": there are " + std::to_string(one.joints.size()) + " joints and " +
                         std::to_string(one.largest_acceleration.size()) + " largest accelerations");
    for (const double value : one.largest_acceleration)
      if (!(value > 0) || !std::isfinite(value))
        throw ControlError(what + ": largest acceleration " + std::to_string(value) +
                           " must be finite and greater than 0");
    if (!limb.parent.empty()) {
      const auto parent = std::ranges::find(found, limb.parent, &LimbJoints::name);
      if (parent == found.end())
        throw ControlError(what + ": its parent '" + limb.parent +
                           "' is none of the limbs before it: " + names_of(found));
      if (!carries(robot, *parent, one))
        throw ControlError(what + ": no joint of its parent '" + limb.parent + "' carries it");
      one.parent = static_cast<std::size_t>(parent - found.begin());
    }
    found.push_back(std::move(one));
  }
  return found;
}

}  // namespace robotskin::control
