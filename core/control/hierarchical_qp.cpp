// SPDX-License-Identifier: Apache-2.0
#include "control/hierarchical_qp.hpp"

#include <algorithm>
#include <cmath>

#include "control/dense_kernels.hpp"

namespace robotskin::control {
namespace {

// A row whose part outside of what is claimed already is shorter than this claims nothing.
constexpr double least_row = 1e-3;
// Of the tolerance, what one active set may miss: the levels add up.
constexpr double part_of_tolerance = 0.1;

}  // namespace

HierarchicalQp::HierarchicalQp(const Sizes& sizes)
    : sizes_(sizes),
      largest_limits_(sizes.limits + sizes.ranges),
      stride_(largest_limits_ + sizes.variables),
      width_(sizes.variables + sizes.ranges),
      turned_(stride_ * width_),
      rows_(sizes.largest_rows * sizes.variables),
      reduced_(sizes.largest_rows * sizes.variables),
      factor_(width_ * width_),
      error_(sizes.largest_rows),
      reflector_(sizes.variables),
      missed_(sizes.levels * sizes.largest_rows),
      row_(sizes.largest_rows),
      missed_count_(sizes.levels),
      claimed_before_(sizes.levels + 1),
      side_(sizes.levels * largest_limits_),
      active_set_(width_, largest_limits_) {
  for (auto* values : {&low_, &high_, &value_, &room_low_, &room_high_}) values->resize(largest_limits_);
  for (auto* values : {&z_, &step_}) values->resize(width_);
  image_.resize(std::max(stride_, sizes.largest_rows));
}

void HierarchicalQp::restart() noexcept {
  std::ranges::fill(side_, std::int8_t{0});
}

std::span<const double> HierarchicalQp::missed(std::size_t level) const noexcept {
  if (level >= sizes_.levels) return {};
  return {missed_.data() + level * sizes_.largest_rows, missed_count_[level]};
}

bool HierarchicalQp::solve(const QpLimits& limits, std::span<const QpLevel> levels, StepBudget& budget,
                           std::span<double> x) noexcept {
  const std::size_t n = sizes_.variables;
  limits_ = limits.low.size();
  if (limits_ > sizes_.limits || limits.high.size() != limits_ || x.size() != n || levels.size() > sizes_.levels)
    return false;
  claimed_ = constrained_ = 0;
  finished_ = levels.size();
  std::ranges::fill(missed_count_, std::size_t{0});
  std::ranges::copy(limits.low, low_.begin());
  std::ranges::copy(limits.high, high_.begin());
  for (std::size_t k = 0; k < n; ++k) {
    std::copy_n(limits.matrix + k * limits_, limits_, column(k));
    std::fill_n(basis(k), n, 0.0);
    basis(k)[k] = 1;
  }
  product(turned_.data(), stride_, limits_, n, x.data(), value_.data());
  for (std::size_t index = 0; index < levels.size(); ++index) {
    claimed_before_[index] = claimed_;
    if (!solve_level(levels[index], index, budget, x)) return false;
    if (index + 1 < levels.size()) claim();
  }
  claimed_before_[levels.size()] = claimed_;
  return true;
}

bool HierarchicalQp::solve_level(const QpLevel& level, std::size_t index, StepBudget& budget,
                                 std::span<double> x) noexcept {
  const std::size_t count = level.low.size(), left = sizes_.variables - claimed_;
  if (count > sizes_.largest_rows || level.high.size() != count) return false;
  sort_rows(level);
  if (limits_ + ranges_ > largest_limits_) return false;
  if (count == 0) return true;
  add_ranges(level, x);
  if (!find_minimum(level, x)) return false;
  if (!meet_limits(&side_[index * largest_limits_], budget)) finished_ = std::min(finished_, index);

  product(left > 0 ? column(claimed_) : nullptr, stride_, limits_, left, z_.data(), image_.data());
  for (std::size_t i = 0; i < limits_; ++i) value_[i] += image_[i];
  product(left > 0 ? basis(claimed_) : nullptr, stride_, x.size(), left, z_.data(), step_.data());
  for (std::size_t i = 0; i < x.size(); ++i)
    if (!std::isfinite(x[i] += step_[i])) return false;
  record(level, index);
  return true;
}

// The level's equations into rows_, its ranges after them into row_ only.
void HierarchicalQp::sort_rows(const QpLevel& level) noexcept {
  const std::size_t count = level.low.size();
  equations_ = ranges_ = 0;
  for (std::size_t i = 0; i < count; ++i)
    if (level.low[i] == level.high[i]) row_[equations_++] = i;
  for (std::size_t i = 0; i < count; ++i)
    if (level.low[i] != level.high[i]) row_[equations_ + ranges_++] = i;
  for (std::size_t k = 0; k < sizes_.variables; ++k)
    for (std::size_t i = 0; i < equations_; ++i) rows_[i + k * equations_] = level.rows[row_[i] + k * count];
}

// A range is one more limit, of a variable more: how far it is missed, whose square is part of the level.
void HierarchicalQp::add_ranges(const QpLevel& level, std::span<const double> x) noexcept {
  const std::size_t count = level.low.size(), n = sizes_.variables;
  for (std::size_t j = 0; j < ranges_; ++j) {
    const std::size_t row = row_[equations_ + j];
    for (std::size_t k = 0; k < n; ++k) reflector_[k] = level.rows[row + k * count];
    double& value = value_[limits_ + j] = 0;
    for (std::size_t k = 0; k < n; ++k) {
      value += reflector_[k] * x[k];
      transposed_product(basis(k), stride_, n, 1, reflector_.data(), column(k) + limits_ + j);
    }
    low_[limits_ + j] = level.low[row];
    high_[limits_ + j] = level.high[row];
    std::fill_n(column(n + j), limits_ + ranges_, 0.0);
    column(n + j)[limits_ + j] = -1;
  }
  limits_ += ranges_;
}

// z = the minimum of |reduced z - error|^2 + least_effort |x + basis z|^2, and the factor of its Hessian.
bool HierarchicalQp::find_minimum(const QpLevel& level, std::span<const double> x) noexcept {
  const std::size_t left = sizes_.variables - claimed_;
  product(rows_.data(), equations_, equations_, x.size(), x.data(), error_.data());
  for (std::size_t i = 0; i < equations_; ++i) error_[i] = level.low[row_[i]] - error_[i];
  for (std::size_t k = 0; k < left; ++k)
    product(rows_.data(), equations_, equations_, x.size(), basis(claimed_ + k), &reduced_[k * equations_]);
  transposed_product(reduced_.data(), equations_, equations_, left, error_.data(), z_.data());
  if (left > 0) transposed_product(basis(claimed_), stride_, x.size(), left, x.data(), step_.data());
  for (std::size_t k = 0; k < left; ++k) {
    z_[k] -= least_effort * step_[k];
    double* own = &factor_[k + k * width_];
    transposed_product(&reduced_[k * equations_], equations_, equations_, left - k, &reduced_[k * equations_], own);
    *own += least_effort;
    std::fill_n(own + (left - k), ranges_, 0.0);
  }
  if (!factorise(factor_.data(), width_, left)) return false;
  solve_lower(factor_.data(), width_, left, z_.data());
  solve_lower_transposed(factor_.data(), width_, left, z_.data());
  for (std::size_t j = left; j < left + ranges_; ++j) {
    std::fill_n(&factor_[j + j * width_], left + ranges_ - j, 0.0);
    factor_[j + j * width_] = 1;
    z_[j] = 0;
  }
  return true;
}

// z: in, the minimum without limits; out, the one within them. False if the budget ended before: z is then what of the
// way there keeps the limits.
bool HierarchicalQp::meet_limits(std::int8_t* side, StepBudget& budget) noexcept {
  const std::size_t size = sizes_.variables - claimed_ + ranges_;
  if (size == 0) return true;
  const std::size_t hard = limits_ - ranges_;
  product(column(claimed_), stride_, limits_, size, z_.data(), image_.data());
  bool inside = true;
  for (std::size_t i = 0; i < limits_; ++i) {
    room_low_[i] = low_[i] - value_[i];
    room_high_[i] = high_[i] - value_[i];
    if (i < hard) {  // what higher levels have stays allowed, whatever rounding makes of it
      room_low_[i] = std::min(room_low_[i], 0.0);
      room_high_[i] = std::max(room_high_[i], 0.0);
    }
    inside = inside && image_[i] >= room_low_[i] - tolerance && image_[i] <= room_high_[i] + tolerance;
  }
  if (inside) {
    std::fill_n(side, limits_, std::int8_t{0});
    return true;
  }
  ++constrained_;
  const ActiveSet::Problem problem{size,
                                   limits_,
                                   factor_.data(),
                                   width_,
                                   column(claimed_),
                                   stride_,
                                   room_low_.data(),
                                   room_high_.data(),
                                   part_of_tolerance * tolerance};
  const ActiveSetOutcome outcome = active_set_.solve(problem, z_.data(), side, budget);
  if (outcome == ActiveSetOutcome::best) return true;
  if (outcome == ActiveSetOutcome::none) {
    std::ranges::fill(z_, 0.0);
    return false;
  }
  product(column(claimed_), stride_, hard, size, z_.data(), image_.data());
  double share = 1;
  for (std::size_t i = 0; i < hard; ++i) {
    const double room = (image_[i] > 0 ? room_high_[i] : -room_low_[i]) + part_of_tolerance * tolerance;
    if (std::abs(image_[i]) * share > room) share = room / std::abs(image_[i]);
  }
  for (double& value : z_) value *= share;
  return false;
}

// What the level misses; lower levels may miss its ranges by no more.
void HierarchicalQp::record(const QpLevel& level, std::size_t index) noexcept {
  double* missed = &missed_[index * sizes_.largest_rows];
  missed_count_[index] = level.low.size();
  product(reduced_.data(), equations_, equations_, sizes_.variables - claimed_, z_.data(), image_.data());
  for (std::size_t i = 0; i < equations_; ++i) missed[row_[i]] = image_[i] - error_[i];
  for (std::size_t i = limits_ - ranges_; i < limits_; ++i) {
    const double value = value_[i];
    missed[row_[equations_ + i - (limits_ - ranges_)]] = value - std::clamp(value, low_[i], high_[i]);
    low_[i] = std::min(low_[i], value);
    high_[i] = std::max(high_[i], value);
  }
}

// Turns the basis of what is left so that its first columns are the level's equations, and counts these as claimed.
void HierarchicalQp::claim() noexcept {
  const std::size_t n = sizes_.variables, before = claimed_;
  for (std::size_t i = 0; i < equations_ && claimed_ < n; ++i) {
    const std::size_t left = n - claimed_;
    double* own = &reduced_[(claimed_ - before) * equations_];
    double square = 0;
    for (std::size_t k = 0; k < left; ++k) {
      reflector_[k] = own[i + k * equations_];
      square += reflector_[k] * reflector_[k];
    }
    const double length = std::sqrt(square);
    if (length < least_row) continue;
    const double first = reflector_[0];
    reflector_[0] += first >= 0 ? length : -length;
    const double factor_of_two = 1 / (square + std::abs(first) * length);
    const auto reflect = [&](double* matrix, std::size_t stride, std::size_t rows) {
      product(matrix, stride, rows, left, reflector_.data(), image_.data());
      for (std::size_t k = 0; k < rows; ++k) image_[k] *= factor_of_two;
      subtract_outer(matrix, stride, rows, left, image_.data(), reflector_.data());
    };
    reflect(column(claimed_), stride_, stride_);
    reflect(own, equations_, equations_);
    ++claimed_;
  }
}

void HierarchicalQp::keep(std::size_t levels, std::span<double> step) noexcept {
  const std::size_t n = sizes_.variables;
  const std::size_t from = claimed_before_[std::min(levels, sizes_.levels)], left = n - from;
  if (left > 0) {
    transposed_product(basis(from), stride_, n, left, step.data(), z_.data());
    product(basis(from), stride_, n, left, z_.data(), step.data());
  } else {
    std::ranges::fill(step, 0.0);
  }
}

double HierarchicalQp::move(std::span<const double> step, std::span<double> x) noexcept {
  const std::size_t n = sizes_.variables;
  transposed_product(basis(0), stride_, n, n, step.data(), z_.data());
  product(turned_.data(), stride_, limits_, n, z_.data(), image_.data());
  double share = 1;
  for (std::size_t i = 0; i < limits_; ++i) {
    const double room = std::max(image_[i] > 0 ? high_[i] - value_[i] : value_[i] - low_[i], 0.0) + tolerance;
    if (std::abs(image_[i]) * share > room) share = room / std::abs(image_[i]);
  }
  for (std::size_t i = 0; i < limits_; ++i) value_[i] += share * image_[i];
  for (std::size_t i = 0; i < n; ++i) x[i] += share * step[i];
  return share;
}

}  // namespace robotskin::control
