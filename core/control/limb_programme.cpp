// SPDX-License-Identifier: Apache-2.0
#include "control/limb_programme.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace robotskin::control {

LimbProgramme::LimbProgramme(LimbJoints limb, std::size_t largest_rows, double effort, double most)
    : limb_(std::move(limb)),
      solver_({.variables = limb_.joints.size(),
               .limits = 2 * limb_.joints.size(),
               .largest_rows = largest_rows + limb_.joints.size(),
               .levels = 1}) {
  const std::size_t joints = limb_.joints.size();
  for (const double own : limb_.largest_acceleration) root_effort_.push_back(std::sqrt(effort) * most / own);
  limits_.resize(2 * joints * joints);
  low_.resize(2 * joints);
  high_.resize(2 * joints);
  rows_.resize((largest_rows + joints) * joints);
  wanted_.resize(largest_rows + joints);
}

bool LimbProgramme::solve(const LimbState& state, std::span<const double> jacobian, std::span<double> residual,
                          StepBudget& budget, std::span<double> change) noexcept {
  const std::size_t joints = limb_.joints.size(), contacts = residual.size(), count = contacts + joints;
  if (jacobian.size() != contacts * joints || count > wanted_.size() || change.size() != joints) return false;
  std::ranges::fill(limits_, 0.0);
  for (std::size_t i = 0; i < joints; ++i) {
    limits_[i * 2 * joints + i] = 1;
    low_[i] = state.low[i] - state.acceleration[i];
    high_[i] = state.high[i] - state.acceleration[i];
    for (std::size_t row = 0; row < joints; ++row)
      limits_[i * 2 * joints + joints + row] = state.mass[row * joints + i];
    // What already takes more than the motor has may not take more still.
    low_[joints + i] = std::min(-state.largest_torque[i] - state.torque[i], 0.0);
    high_[joints + i] = std::max(state.largest_torque[i] - state.torque[i], 0.0);
  }
  for (std::size_t i = 0; i < joints; ++i) {
    double* column = &rows_[i * count];
    for (std::size_t row = 0; row < contacts; ++row) column[row] = jacobian[row * joints + i];
    std::fill_n(column + contacts, joints, 0.0);
    column[contacts + i] = root_effort_[i];
  }
  std::ranges::copy(residual, wanted_.begin());
  for (std::size_t i = 0; i < joints; ++i) wanted_[contacts + i] = -root_effort_[i] * state.changed[i];
  std::ranges::fill(change, 0.0);
  const QpLevel level{rows_.data(), {wanted_.data(), count}, {wanted_.data(), count}};
  // [Cheng19 eq. 27]
  if (!solver_.solve({limits_.data(), low_, high_}, {&level, 1}, budget, change)) return false;
  for (std::size_t row = 0; row < contacts; ++row)
    for (std::size_t i = 0; i < joints; ++i) residual[row] -= jacobian[row * joints + i] * change[i];
  return std::ranges::all_of(change, [](double value) { return std::isfinite(value); });
}

}  // namespace robotskin::control
