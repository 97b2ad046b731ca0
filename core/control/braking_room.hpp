// SPDX-License-Identifier: Apache-2.0
// Where limits of acceleration and torque seem to exclude each other: a torque that keeps as many as can be kept.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "control/hierarchical_qp.hpp"

namespace robotskin::control {

// In coordinates t = L^-1 tau, M = L L^T, as QuadraticFusion has them.
class BrakingRoom {
 public:
  explicit BrakingRoom(std::size_t joint_count);

  // Of all t whose torque L t is within its bounds, one that misses the bounds of acceleration L^-T t by the least sum
  // of squares, with some room around it. `t` (n) is a first guess before, any one, and that one after; `low` and
  // `high` (2 n) bound acceleration, then torque, and where an acceleration is missed its bound moves there. `factor`
  // (n, n) is L; the first n rows of `matrix` (2 n, n) are L^-T, both by columns. False where all bounds are kept.
  // Allocates nothing.
  bool find(const double* factor, const double* matrix, std::span<double> low, std::span<double> high,
            StepBudget& budget, std::span<double> t) noexcept;

 private:
  std::size_t n_;
  std::vector<double> rows_, low_, high_, torque_, acceleration_;
  HierarchicalQp solver_;
};

}  // namespace robotskin::control
