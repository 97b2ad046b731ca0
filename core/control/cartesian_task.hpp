// SPDX-License-Identifier: Apache-2.0
// Cartesian task: an impedance that draws a link's frame to its reference.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "control/task.hpp"
#include "control/vector_mailbox.hpp"
#include "model/robot_model.hpp"

namespace robotskin::control {

// Entries: along x, y, z of the base, N/m and N s/m; about x, y, z of the base, Nm/rad and Nm s/rad.
struct CartesianGains {
  std::array<double, 6> stiffness;
  std::array<double, 6> damping;
};

// torque = J^T (K e + D (reference' - J v)), e the position error and the rotation vector to the reference. Axes
// without gains are left to lower levels: 3 rows for a position, 6 for a pose.
class CartesianTask : public Task {
 public:
  // Throws ModelError for an unknown link, ControlError for a link on the base and for gains that are not finite or
  // negative. The reference is where the task starts.
  CartesianTask(const RobotModel& robot, const std::string& link, CartesianGains gains, std::string name = "Cartesian");

  // From any thread; base_from_link (16) row-major, a rotation and metres, else ControlError.
  void request_reference(std::span<const double> base_from_link);

  void start(const TaskInput& input) noexcept override;
  [[nodiscard]] bool update(const TaskInput& input) noexcept override;
  std::span<const double> reference() const noexcept { return reference_; }  // (16)
  std::span<const double> error() const noexcept { return error_; }          // (6) m, rad of the last update

 protected:
  virtual void follow(const TaskInput& input, bool fresh) noexcept;

  std::array<double, 16> goal_{}, reference_{};
  std::array<double, 6> reference_velocity_{};

 private:
  std::size_t link_;
  CartesianGains gains_;
  VectorMailbox goal_box_;
  std::array<double, 16> scratch_{};
  std::array<double, 6> error_{};
  std::vector<double> jacobian_;  // (6, n)
};

}  // namespace robotskin::control
