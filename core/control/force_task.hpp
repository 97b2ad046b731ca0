// SPDX-License-Identifier: Apache-2.0
// Force task: the limb presses on its surroundings with a force that its skin measures.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "control/task.hpp"
#include "control/touch_wrench.hpp"
#include "control/vector_mailbox.hpp"
#include "model/robot_model.hpp"

namespace robotskin::control {

struct ForceGains {
  double integral = 2;        // 1/s, of the force that is missing
  double damping = 100;       // N s/m of the frame
  double largest_force = 50;  // N, bound of what is commanded along each axis
};

// torque = J_v^T (F + integral of k (F - F_measured) - D v), F newton along the axes of the base, F_measured the force
// with which the cells on all that the link's joint carries say that they press. Claims 3 rows.
class ForceTask final : public Task {
 public:
  // `felt`: the force felt, which is a touch of weight 1 (SkinGains::measured_force). Throws ModelError for an unknown
  // link, ControlError for a link on the base and gains that do not fit.
  ForceTask(const RobotModel& robot, std::shared_ptr<TouchWrench> felt, const std::string& link, ForceGains gains);

  // From any thread; (3) newton, no longer than largest_force, else ControlError.
  void request_force(std::span<const double> force);
  void start(const TaskInput& input) noexcept override;
  [[nodiscard]] bool update(const TaskInput& input) noexcept override;
  const Vector3& measured() const noexcept { return measured_; }  // newton, base frame

 private:
  std::shared_ptr<TouchWrench> felt_;
  ForceGains gains_;
  std::size_t link_, joint_;
  VectorMailbox force_box_;
  Vector3 force_{}, integral_{}, measured_{}, scratch_{};
  std::vector<double> jacobian_;  // (6, n)
};

}  // namespace robotskin::control
