// SPDX-License-Identifier: Apache-2.0
// Contact-point impedance [Cheng19 eq. 26]: where a link is touched, it moves like a mass on a spring and a damper.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "control/task.hpp"
#include "control/touch_wrench.hpp"

namespace robotskin::control {

// W = inertia x'' + damping x' + stiffness x, the same along every axis.
struct ContactImpedanceGains {
  double inertia = 2.5;   // kg
  double damping = 14;    // N s/m
  double stiffness = 20;  // N/m
};

// x is how far the contact's centroid has come from where the same point of the link was when the touch began. The
// torque J^T (J M^-1 J^T)^-1 x'' gives that point the acceleration that [Cheng19 eq. 26] asks for, whatever the mass of
// the arm; singular directions are damped. Claims 3 rows for each touched body.
class ContactImpedanceTask final : public Task {
 public:
  // Throws ControlError. The gains of the touch turn what cells sense into the wrench W.
  ContactImpedanceTask(std::shared_ptr<TouchWrench> touch, ContactImpedanceGains gains);
  void start(const TaskInput& input) noexcept override;
  [[nodiscard]] bool update(const TaskInput& input) noexcept override;

 private:
  struct Contact {
    bool touched = false;
    std::array<double, 16> base_from_joint;  // when the touch began
  };
  bool add(const TaskInput& input, std::size_t body) noexcept;

  std::shared_ptr<TouchWrench> touch_;
  ContactImpedanceGains gains_;
  std::vector<Contact> contacts_;  // (bodies)
  std::vector<double> jacobian_;   // (3, n) of the contact
  std::vector<double> response_;   // (3, n) M^-1 J^T, a row each
};

}  // namespace robotskin::control
