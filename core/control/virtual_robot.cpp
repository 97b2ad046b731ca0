// SPDX-License-Identifier: Apache-2.0
#include "control/virtual_robot.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <string>
#include <utility>

#include "control/control_error.hpp"

namespace robotskin::control {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using ConstVector = Eigen::Map<const Eigen::VectorXd>;

struct VirtualRobot::Solver {
  explicit Solver(Eigen::Index joints) : matrix(joints, joints) {}
  Matrix matrix;  // factored in place
};

VirtualRobot::VirtualRobot(VirtualRobotGains gains, std::size_t joint_count)
    : gains_(std::move(gains)), solver_(std::make_unique<Solver>(static_cast<Eigen::Index>(joint_count))) {
  const auto check = [joint_count](const char* name, const std::vector<double>& values) {
    if (values.size() != joint_count)
      throw ControlError(std::string("virtual robot: ") + name + " has " + std::to_string(values.size()) +
                         " values, the robot has " + std::to_string(joint_count) + " joints");
    for (const double value : values)
      if (!std::isfinite(value) || value < 0)
        throw ControlError(std::string("virtual robot: ") + name + " " + std::to_string(value) +
                           " must be finite and not negative");
  };
  check("inertia", gains_.inertia);
  check("friction", gains_.friction);
}

VirtualRobot::~VirtualRobot() = default;
VirtualRobot::VirtualRobot(VirtualRobot&&) noexcept = default;
VirtualRobot& VirtualRobot::operator=(VirtualRobot&&) noexcept = default;

bool VirtualRobot::acceleration(const RobotDynamics& dynamics, std::span<const double> velocity,
                                std::span<const double> torque, double period_s, std::span<double> acceleration,
                                std::span<const CommandMode> mode) noexcept {
  const auto joints = solver_->matrix.rows();
  const auto vector = [joints](std::span<const double> values) { return ConstVector(values.data(), joints); };
  solver_->matrix = Eigen::Map<const Matrix>(dynamics.mass_matrix().data(), joints, joints);
  solver_->matrix.diagonal() += vector(gains_.inertia) + period_s * vector(gains_.friction);

  Eigen::Map<Eigen::VectorXd> result(acceleration.data(), joints);
  result =
      vector(torque) - vector(dynamics.nonlinear_effects()) - vector(gains_.friction).cwiseProduct(vector(velocity));
  for (std::size_t i = 0; i < mode.size(); ++i) {
    if (mode[i] == CommandMode::torque) continue;
    const auto joint = static_cast<Eigen::Index>(i);
    solver_->matrix.row(joint).setZero();
    solver_->matrix.col(joint).setZero();
    solver_->matrix(joint, joint) = 1;
    result[joint] = 0;
  }
  const Eigen::LLT<Eigen::Ref<Matrix>> factor(solver_->matrix);
  if (factor.info() != Eigen::Success) return false;
  factor.solveInPlace(result);
  return result.allFinite();
}

}  // namespace robotskin::control
