// SPDX-License-Identifier: Apache-2.0
// The programme of one limb: the joint accelerations that leave least of what its contacts are to do [Cheng19 eq. 27].
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "control/hierarchical_qp.hpp"
#include "control/limb.hpp"
#include "control/step_budget.hpp"

namespace robotskin::control {

// A limb's joints in a tick; k joints.
struct LimbState {
  std::span<const double> acceleration;    // (k) rad/s^2 that they have so far, within the bounds
  std::span<const double> changed;         // (k) by how much that is more than if there were no contact
  std::span<const double> low, high;       // (k) rad/s^2
  std::span<const double> mass;            // (k, k) kg m^2
  std::span<const double> torque;          // (k) Nm that the accelerations take so far
  std::span<const double> largest_torque;  // (k) Nm
};

// min over d of sum of psi |r - J d|^2 + effort |changed + d|^2, where r is what is missing of the accelerations that
// the contacts are to have, within bounds on acceleration, which hold position and velocity limits, and on torque.
class LimbProgramme {
 public:
  // `largest_rows`: of the contacts of a tick, 3 each. `effort` is that of a joint that may accelerate by `most`; one
  // that may less is dearer by the square of how much.
  LimbProgramme(LimbJoints limb, std::size_t largest_rows, double effort, double most);

  const LimbJoints& limb() const noexcept { return limb_; }

  // jacobian (rows, k) and residual (rows) of the contacts, both times the root of psi. Fills `change` (k), the d of
  // above, and takes what it does from the residual. False if there is no finite answer. Allocates nothing.
  [[nodiscard]] bool solve(const LimbState& state, std::span<const double> jacobian, std::span<double> residual,
                           StepBudget& budget, std::span<double> change) noexcept;

 private:
  LimbJoints limb_;
  std::vector<double> root_effort_;          // (k)
  std::vector<double> limits_, low_, high_;  // (2 k, k) by columns, (2 k)
  std::vector<double> rows_, wanted_;        // (rows + k, k) by columns, (rows + k)
  HierarchicalQp solver_;
};

}  // namespace robotskin::control
