// SPDX-License-Identifier: Apache-2.0
// Calls Pinocchio's algorithms, each once, in the instantiation that the wheel's library already holds.
#include "model/robot_dynamics.hpp"

#include <algorithm>
#include <cmath>
#include <pinocchio/algorithm/cholesky.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <vector>

#include "model/spatial.hpp"

namespace robotskin {
namespace {

// The argument type for which the library holds the algorithms; another one would compile them again.
using VectorView = Eigen::Ref<const Eigen::VectorXd>;

bool all_finite(std::span<const double> values) noexcept {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

std::span<const double> flat(const Eigen::VectorXd& vector) noexcept {
  return {vector.data(), static_cast<std::size_t>(vector.size())};
}

}  // namespace

struct RobotDynamics::Workspace {
  std::shared_ptr<const pinocchio::Model> model;
  pinocchio::Data data;
  Eigen::VectorXd q, v;
  Eigen::MatrixXd solution;  // (n, 1), the shape Pinocchio's Cholesky solver takes
  std::vector<double> base_from_joint, joint_from_link;
  std::vector<int> link_joints;

  Workspace(std::shared_ptr<const pinocchio::Model> robot, std::span<const double> placements,
            std::span<const int> joints)
      : model(std::move(robot)),
        data(*model),
        q(Eigen::VectorXd::Zero(model->nv)),
        v(Eigen::VectorXd::Zero(model->nv)),
        solution(model->nv, 1),
        base_from_joint(16 * static_cast<std::size_t>(model->nv)),
        joint_from_link(placements.begin(), placements.end()),
        link_joints(joints.begin(), joints.end()) {
    data.M.setZero();
  }

  std::size_t joint_count() const noexcept { return static_cast<std::size_t>(q.size()); }

  void compute() {
    const VectorView posture(q), velocity(v);
    pinocchio::nonLinearEffects(*model, data, posture, velocity);
    pinocchio::computeGeneralizedGravity(*model, data, posture);
    // In the world convention the composite-rigid-body algorithm leaves placements and Jacobian in the base frame.
    pinocchio::crba(*model, data, posture, pinocchio::Convention::WORLD);
    data.M.triangularView<Eigen::StrictlyLower>() = data.M.transpose().triangularView<Eigen::StrictlyLower>();
    pinocchio::cholesky::decompose(*model, data);
    for (std::size_t joint = 0; joint < joint_count(); ++joint) {
      write_placement(data.oMi[joint + 1], &base_from_joint[16 * joint]);
    }
  }

  void base_from_link(std::size_t link, double* out) const noexcept {
    const int joint = link_joints[link];
    if (joint == RobotModel::base) {
      std::copy_n(&joint_from_link[16 * link], 16, out);
    } else {
      multiply_placements(&base_from_joint[16 * static_cast<std::size_t>(joint)], &joint_from_link[16 * link], out);
    }
  }

  void solve(std::span<double> out) {
    pinocchio::cholesky::solve(*model, data, solution);
    std::copy_n(solution.data(), out.size(), out.data());
  }
};

RobotDynamics::RobotDynamics(const RobotModel& model)
    : workspace_(std::make_unique<Workspace>(std::static_pointer_cast<const pinocchio::Model>(model.pinocchio_model_),
                                             model.joint_from_link(), model.link_joints())) {
  workspace_->compute();
}

RobotDynamics::~RobotDynamics() = default;
RobotDynamics::RobotDynamics(RobotDynamics&&) noexcept = default;
RobotDynamics& RobotDynamics::operator=(RobotDynamics&&) noexcept = default;

std::size_t RobotDynamics::joint_count() const noexcept {
  return workspace_->joint_count();
}
std::size_t RobotDynamics::link_count() const noexcept {
  return workspace_->link_joints.size();
}

bool RobotDynamics::update(std::span<const double> q, std::span<const double> v) noexcept {
  const std::size_t count = joint_count();
  if (q.size() != count || v.size() != count || !all_finite(q) || !all_finite(v)) return false;
  std::copy(q.begin(), q.end(), workspace_->q.data());
  std::copy(v.begin(), v.end(), workspace_->v.data());
  workspace_->compute();
  return true;
}

std::span<const double> RobotDynamics::base_from_joint() const noexcept {
  return workspace_->base_from_joint;
}

std::span<const double> RobotDynamics::joint_motions() const noexcept {
  // Pinocchio's 6 x n Jacobian is stored by columns, which is (n, 6) by rows.
  return {workspace_->data.J.data(), 6 * joint_count()};
}

std::span<const double> RobotDynamics::mass_matrix() const noexcept {
  return {workspace_->data.M.data(), joint_count() * joint_count()};
}

std::span<const double> RobotDynamics::gravity_torque() const noexcept {
  return flat(workspace_->data.g);
}
std::span<const double> RobotDynamics::nonlinear_effects() const noexcept {
  return flat(workspace_->data.nle);
}

// The composite-rigid-body algorithm has left the inertia of all that a joint carries, in the base frame, in oYcrb.
double RobotDynamics::mass() const noexcept {
  const pinocchio::Model& model = *workspace_->model;
  double mass = model.inertias[0].mass();
  for (std::size_t joint = 1; joint <= joint_count(); ++joint)
    if (model.parents[joint] == 0) mass += workspace_->data.oYcrb[joint].mass();
  return mass;
}

std::array<double, 3> RobotDynamics::centre_of_mass() const noexcept {
  const pinocchio::Model& model = *workspace_->model;
  Eigen::Vector3d sum = model.inertias[0].mass() * model.inertias[0].lever();
  for (std::size_t joint = 1; joint <= joint_count(); ++joint) {
    if (model.parents[joint] != 0) continue;
    const auto& carried = workspace_->data.oYcrb[joint];
    sum += carried.mass() * carried.lever();
  }
  sum /= mass();
  return {sum[0], sum[1], sum[2]};
}

bool RobotDynamics::centre_of_mass_jacobian(std::span<double> out) const noexcept {
  const std::size_t count = joint_count();
  if (out.size() != 3 * count) return false;
  const double all = mass();
  for (std::size_t joint = 0; joint < count; ++joint) {
    const auto motion = workspace_->data.J.col(static_cast<Eigen::Index>(joint));
    const auto& carried = workspace_->data.oYcrb[joint + 1];
    const Eigen::Vector3d velocity =
        carried.mass() / all * (motion.head<3>() + motion.tail<3>().cross(carried.lever()));
    for (std::size_t row = 0; row < 3; ++row) out[row * count + joint] = velocity[static_cast<Eigen::Index>(row)];
  }
  return true;
}

bool RobotDynamics::forward_dynamics(std::span<const double> torque, std::span<double> acceleration) const noexcept {
  const std::size_t count = joint_count();
  if (torque.size() != count || acceleration.size() != count) return false;
  for (std::size_t joint = 0; joint < count; ++joint) {
    const auto row = static_cast<Eigen::Index>(joint);
    workspace_->solution(row, 0) = torque[joint] - workspace_->data.nle[row];
  }
  workspace_->solve(acceleration);
  return true;
}

bool RobotDynamics::solve_mass(std::span<const double> right_side, std::span<double> solution) const noexcept {
  const std::size_t count = joint_count();
  if (right_side.size() != count || solution.size() != count) return false;
  std::copy(right_side.begin(), right_side.end(), workspace_->solution.data());
  workspace_->solve(solution);
  return true;
}

bool RobotDynamics::base_from_link(std::size_t link, std::span<double> out) const noexcept {
  if (link >= link_count() || out.size() != 16) return false;
  workspace_->base_from_link(link, out.data());
  return true;
}

bool RobotDynamics::link_jacobian(std::size_t link, std::span<double> out) const noexcept {
  const std::size_t count = joint_count();
  if (link >= link_count() || out.size() != 6 * count) return false;
  std::fill(out.begin(), out.end(), 0.0);
  double placement[16];
  workspace_->base_from_link(link, placement);
  const Eigen::Vector3d origin(placement[3], placement[7], placement[11]);
  const pinocchio::Model& model = *workspace_->model;
  auto joint = static_cast<pinocchio::JointIndex>(workspace_->link_joints[link] + 1);  // Pinocchio's 0 is the base
  for (; joint > 0; joint = model.parents[joint]) {
    const std::size_t column = joint - 1;
    const auto motion = workspace_->data.J.col(static_cast<Eigen::Index>(column));
    // The body point at the link's origin moves with the velocity at the base origin plus omega x origin.
    const Eigen::Vector3d linear = motion.head<3>() + motion.tail<3>().cross(origin);
    for (int row = 0; row < 3; ++row) {
      out[static_cast<std::size_t>(row) * count + column] = linear[row];
      out[static_cast<std::size_t>(row + 3) * count + column] = motion[row + 3];
    }
  }
  return true;
}

}  // namespace robotskin
