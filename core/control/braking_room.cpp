// SPDX-License-Identifier: Apache-2.0
#include "control/braking_room.hpp"

#include <algorithm>

#include "control/dense_kernels.hpp"

namespace robotskin::control {
namespace {

// Of what lies between two bounds, kept free at either end: the search from here on needs some room to move in.
constexpr double room_share = 0.01;

}  // namespace

BrakingRoom::BrakingRoom(std::size_t joint_count)
    : n_(joint_count),
      rows_(n_ * n_),
      low_(2 * n_),
      high_(2 * n_),
      torque_(n_),
      acceleration_(n_),
      solver_({.variables = n_, .limits = n_, .largest_rows = n_, .levels = 1, .ranges = n_}) {}

FoundRoom BrakingRoom::find(const double* factor, const double* matrix, std::span<double> low, std::span<double> high,
                            std::span<double> t) noexcept {
  for (std::size_t k = 0; k < n_; ++k) std::copy_n(matrix + 2 * n_ * k, n_, &rows_[n_ * k]);
  for (std::size_t i = 0; i < 2 * n_; ++i) {
    const double room = room_share * (high[i] - low[i]);
    low_[i] = low[i] + room;
    high_[i] = high[i] - room;
  }
  product(factor, n_, n_, n_, t.data(), torque_.data());
  for (std::size_t i = 0; i < n_; ++i) torque_[i] = std::clamp(torque_[i], low_[n_ + i], high_[n_ + i]);
  std::ranges::copy(torque_, t.begin());
  solve_lower(factor, n_, n_, t.data());
  const std::span<const double> inner_low{low_}, inner_high{high_};
  const QpLimits torque{factor, inner_low.subspan(n_), inner_high.subspan(n_)};
  const QpLevel acceleration{rows_.data(), inner_low.first(n_), inner_high.first(n_)};
  StepBudget budget{.most = steps_per_joint * n_};
  if (!solver_.solve(torque, {&acceleration, 1}, budget, t)) solver_.restart();
  product(rows_.data(), n_, n_, n_, t.data(), acceleration_.data());
  bool moved = false;
  for (std::size_t i = 0; i < n_; ++i) {
    const double room = low_[i] - low[i];
    const bool below = acceleration_[i] < low[i];
    const bool above = acceleration_[i] > high[i];
    moved = moved || below || above;
    // A bound that is kept stays where it is, however near to it the acceleration lies.
    if (below) low[i] = acceleration_[i] - room;
    if (above) high[i] = acceleration_[i] + room;
  }
  return {.steps = budget.taken, .moved = moved, .cut = moved && budget.taken >= budget.most};
}

}  // namespace robotskin::control
