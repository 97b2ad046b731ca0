// SPDX-License-Identifier: Apache-2.0
// Reads a URDF with Pinocchio's parser and copies what is constant into plain arrays.
#include "model/robot_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <pinocchio/parsers/urdf.hpp>

#include "model/spatial.hpp"

namespace robotskin {
namespace {

pinocchio::Model parse(const std::string& urdf) {
  pinocchio::Model model;
  try {
    pinocchio::urdf::buildModelFromXML(urdf, model);
  } catch (const std::exception& error) {
    throw ModelError(std::string("the text is not a URDF of a robot: ") + error.what());
  }
  return model;
}

// A limit at or beyond RobotModel::unbounded stands for none.
double limit_or_infinity(double value) {
  return std::abs(value) < RobotModel::unbounded ? value
                                                 : std::copysign(std::numeric_limits<double>::infinity(), value);
}

std::size_t index_in(std::span<const std::string> names, std::string_view name, const char* kind,
                     const std::string& robot) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  std::string message = "robot '" + robot + "' has no " + kind + " '" + std::string(name) + "'; it has";
  for (const std::string& choice : names) message += " " + choice;
  throw ModelError(message);
}

}  // namespace

RobotModel::RobotModel(const std::string& urdf, const RotorInertia& rotor_inertia) {
  const auto shared_model = std::make_shared<pinocchio::Model>(parse(urdf));
  const pinocchio::Model& model = *shared_model;
  pinocchio_model_ = shared_model;
  name_ = model.name;

  const auto joint_count = static_cast<std::size_t>(model.njoints - 1);
  parent_from_joint_.resize(16 * joint_count);
  for (std::size_t joint = 0; joint < joint_count; ++joint) {
    const pinocchio::JointIndex index = joint + 1;
    const pinocchio::JointModel& joint_model = model.joints[index];
    if (joint_model.nq() != 1 || joint_model.nv() != 1) {
      throw ModelError("joint '" + model.names[index] + "' of robot '" + name_ + "' is of kind " +
                       joint_model.shortname() + "; a joint must be revolute, prismatic or fixed");
    }
    pinocchio::JointData joint_data = joint_model.createData();
    joint_model.calc(joint_data, pinocchio::neutral(model));
    const Eigen::Matrix<double, 6, 1> axis = joint_data.S().matrix();
    const bool prismatic = axis.head<3>().squaredNorm() > 0.5;
    const Eigen::Vector3d direction = prismatic ? axis.head<3>() : axis.tail<3>();

    joint_names_.push_back(model.names[index]);
    joint_parents_.push_back(static_cast<int>(model.parents[index]) - 1);
    joint_kinds_.push_back(prismatic ? JointKind::prismatic : JointKind::revolute);
    joint_axes_.insert(joint_axes_.end(), direction.data(), direction.data() + 3);
    write_placement(model.jointPlacements[index], &parent_from_joint_[16 * joint]);
    const auto position = joint_model.idx_v();
    lower_.push_back(limit_or_infinity(model.lowerPositionLimit[position]));
    upper_.push_back(limit_or_infinity(model.upperPositionLimit[position]));
    velocity_limit_.push_back(limit_or_infinity(model.upperVelocityLimit[position]));
    effort_limit_.push_back(limit_or_infinity(model.upperEffortLimit[position]));
    const double damping = model.damping[position];
    if (!(damping >= 0) || !std::isfinite(damping))
      throw ModelError("joint '" + model.names[index] + "' of robot '" + name_ + "' has a damping of " +
                       std::to_string(damping) + "; it must be finite and not negative");
    joint_damping_.push_back(damping);
  }
  rotor_inertia_.resize(joint_count);
  for (const auto& [joint, inertia] : rotor_inertia) {
    if (!(inertia >= 0) || !std::isfinite(inertia))
      throw ModelError("joint '" + joint + "' of robot '" + name_ + "' has a rotor inertia of " +
                       std::to_string(inertia) + "; it must be finite and not negative");
    rotor_inertia_[joint_index(joint)] = inertia;
  }
  for (std::size_t joint = 0; joint < joint_count; ++joint)
    shared_model->armature[model.joints[joint + 1].idx_v()] = rotor_inertia_[joint];
  constexpr std::size_t base_joints = 6;
  bool floats = joint_count > base_joints;
  for (std::size_t joint = 0; floats && joint < base_joints; ++joint)
    floats = effort_limit_[joint] == 0 && joint_parents_[joint] == static_cast<int>(joint) - 1 &&
             (joint_kinds_[joint] == JointKind::prismatic) == (joint < 3);
  floating_joints_ = floats ? base_joints : 0;

  for (const pinocchio::Frame& frame : model.frames) {
    if (frame.type != pinocchio::BODY) continue;
    link_names_.push_back(frame.name);
    link_joints_.push_back(static_cast<int>(frame.parentJoint) - 1);
    joint_from_link_.resize(joint_from_link_.size() + 16);
    write_placement(frame.placement, &joint_from_link_[joint_from_link_.size() - 16]);
  }
}

std::size_t RobotModel::joint_index(std::string_view joint) const {
  return index_in(joint_names_, joint, "joint", name_);
}

std::size_t RobotModel::link_index(std::string_view link) const {
  return index_in(link_names_, link, "link", name_);
}

}  // namespace robotskin
