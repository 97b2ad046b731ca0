// The Cartesian tasks of a stack: an impedance of a link's frame about a fixed pose, and about one that moves along a
// spline.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "control/mailbox.hpp"
#include "control/quintic.hpp"
#include "control/task.hpp"
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
  Mailbox goal_box_;
  std::array<double, 16> scratch_{};
  std::array<double, 6> error_{};
  std::vector<double> jacobian_;  // (6, n)
};

// Position and orientation move together, along a straight line and about one axis, by one quintic. A new goal under
// way begins from the reference's place and velocity along the new line, its other velocity is dropped.
class SplineCartesianTask final : public CartesianTask {
 public:
  // speed in m/s and turn_speed in rad/s, > 0.
  SplineCartesianTask(const RobotModel& robot, const std::string& link, CartesianGains gains, double speed,
                      double turn_speed);

  void start(const TaskInput& input) noexcept override;
  bool arrived() const noexcept { return time_s_ >= duration_s_; }

 protected:
  void follow(const TaskInput& input, bool fresh) noexcept override;

 private:
  double speed_, turn_speed_;
  double time_s_ = 0, duration_s_ = 0;
  Quintic share_;  // 0 to 1 of the way
  std::array<double, 16> begin_{};
  std::array<double, 3> way_{}, turn_{};  // m, rad, base frame
};

}  // namespace robotskin::control
