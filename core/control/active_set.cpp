#include "control/active_set.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "control/dense_kernels.hpp"

namespace robotskin::control {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
// Share of a normal's square that has to be independent of the active ones for a step along it; for a guess, more.
constexpr double independent = 1e-12;
constexpr double independent_guess = 1e-8;
// A shorter normal, against the longest, belongs to a constraint on which nothing has an influence any more.
constexpr double shortest = 1e-10;

}  // namespace

ActiveSet::ActiveSet(std::size_t largest_size, std::size_t largest_constraints)
    : capacity_(largest_size),
      room_(largest_constraints),
      normals_(room_ * capacity_),
      basis_(capacity_ * capacity_),
      triangle_(capacity_ * capacity_),
      row_(capacity_),
      sign_(capacity_),
      side_(room_) {
  for (auto* values : {&length_, &low_, &high_, &value_}) values->resize(room_);
  for (auto* values : {&y_, &multiplier_, &bound_, &normal_, &turned_, &step_, &share_}) values->resize(capacity_);
}

bool ActiveSet::solve(const Problem& problem, double* x, std::int8_t* side) noexcept {
  size_ = problem.size;
  constraints_ = problem.constraints;
  steps_ = 0;
  if (size_ > capacity_ || constraints_ > room_) return false;
  product(problem.matrix, problem.matrix_stride, constraints_, size_, x, value_.data());
  for (std::size_t i = 0; i < constraints_; ++i) {
    low_[i] = problem.low[i] - value_[i];
    high_[i] = problem.high[i] - value_[i];
  }
  std::fill_n(length_.begin(), constraints_, 0.0);
  for (std::size_t k = 0; k < size_; ++k)
    std::copy_n(problem.matrix + k * problem.matrix_stride, constraints_, &normals_[k * room_]);
  divide_by_transposed(problem.factor, problem.factor_stride, size_, normals_.data(), room_, constraints_);
  for (std::size_t k = 0; k < size_; ++k)
    for (std::size_t i = 0; i < constraints_; ++i) length_[i] += normals_[i + k * room_] * normals_[i + k * room_];
  double longest = 0;
  for (std::size_t i = 0; i < constraints_; ++i) longest = std::max(longest, length_[i] = std::sqrt(length_[i]));

  std::copy_n(side, constraints_, side_.begin());
  if (!search(problem.tolerance, shortest * longest)) {
    std::ranges::fill(side_, std::int8_t{0});
    if (!search(problem.tolerance, shortest * longest)) return false;
  }
  std::copy_n(side_.begin(), constraints_, side);
  solve_lower_transposed(problem.factor, problem.factor_stride, size_, y_.data());
  bool finite = true;
  for (std::size_t i = 0; i < size_; ++i) finite = std::isfinite(x[i] += y_[i]) && finite;
  return finite;
}

bool ActiveSet::search(double tolerance, double least_length) noexcept {
  start_from_guess(least_length);
  const std::size_t most = steps_ + 10 * size_ + constraints_;
  for (;;) {
    product(normals_.data(), room_, constraints_, size_, y_.data(), value_.data());
    std::size_t worst = constraints_;
    double miss = 0, farthest = 0, sign = 1;
    for (std::size_t i = 0; i < constraints_; ++i) {
      const double below = low_[i] - value_[i], above = value_[i] - high_[i], own = std::max(below, above);
      if (side_[i] != 0 || !(own > tolerance) || !(own > farthest * length_[i]) || length_[i] < least_length) continue;
      farthest = own / length_[i];
      miss = own;
      worst = i;
      sign = below > above ? 1 : -1;
    }
    if (worst == constraints_) return true;
    for (;;) {
      if (++steps_ > most) return false;
      const double along = split(worst, sign);
      double partial = infinity;  // until the multiplier of an active constraint is used up
      std::size_t blocking = active_;
      for (std::size_t i = 0; i < active_; ++i)
        if (share_[i] > 0 && multiplier_[i] < partial * share_[i]) {
          partial = multiplier_[i] / share_[i];
          blocking = i;
        }
      const bool moves = active_ < size_ && along > independent * length_[worst] * length_[worst];
      const double whole = moves ? miss / along : infinity;
      const double length = std::min(partial, whole);
      if (length == infinity) return false;  // the constraints exclude each other
      for (std::size_t i = 0; i < active_; ++i) multiplier_[i] -= length * share_[i];
      if (moves && whole <= partial) {
        add(worst, sign, along);
        follow_bounds();
        for (std::size_t i = 0; i < active_; ++i) multiplier_[i] = std::max(multiplier_[i], 0.0);
        break;
      }
      if (moves) miss -= length * along;
      drop(blocking);
    }
  }
}

// The minimum under those of the guessed constraints that push.
void ActiveSet::start_from_guess(double least_length) noexcept {
  active_ = 0;
  for (std::size_t k = 0; k < size_; ++k) {
    std::fill_n(&basis_[k * capacity_], size_, 0.0);
    basis_[k + k * capacity_] = 1;
  }
  for (std::size_t i = 0; i < constraints_; ++i) {
    if (side_[i] == 0) continue;
    const double sign = side_[i] < 0 ? 1 : -1;
    side_[i] = 0;
    if (active_ == size_ || length_[i] < least_length) continue;
    const double along = split(i, sign);
    if (along > independent_guess * length_[i] * length_[i]) add(i, sign, along), ++steps_;
  }
  for (;;) {
    follow_bounds();
    const auto least =
        std::min_element(multiplier_.begin(), multiplier_.begin() + static_cast<std::ptrdiff_t>(active_));
    if (active_ == 0 || *least >= 0) return;
    drop(static_cast<std::size_t>(least - multiplier_.begin()));
    ++steps_;
  }
}

// turned = the constraint's normal along the basis, step = the part of it that is independent of the active ones, whose
// square is returned, share = how the active ones make up the rest.
double ActiveSet::split(std::size_t constraint, double sign) noexcept {
  for (std::size_t k = 0; k < size_; ++k) normal_[k] = sign * normals_[constraint + k * room_];
  transposed_product(basis_.data(), capacity_, size_, size_, normal_.data(), turned_.data());
  std::copy_n(turned_.begin(), active_, share_.begin());
  solve_lower_transposed(triangle_.data(), capacity_, active_, share_.data());
  double along = 0;
  for (std::size_t k = active_; k < size_; ++k) along += turned_[k] * turned_[k];
  return along;
}

// After split: the basis turns so that its next column is the part that was independent.
void ActiveSet::add(std::size_t constraint, double sign, double along) noexcept {
  double* rest = &turned_[active_];
  double* column = &basis_[active_ * capacity_];
  const double diagonal = *rest > 0 ? -std::sqrt(along) : std::sqrt(along);
  product(column, capacity_, size_, size_ - active_, rest, step_.data());
  const double factor = 1 / (along - diagonal * *rest);
  for (std::size_t i = 0; i < size_; ++i) step_[i] = factor * (step_[i] - diagonal * column[i]);
  *rest -= diagonal;
  subtract_outer(column, capacity_, size_, size_ - active_, step_.data(), rest);
  for (std::size_t k = 0; k < active_; ++k) triangle_[active_ + k * capacity_] = turned_[k];
  triangle_[active_ + active_ * capacity_] = diagonal;
  row_[active_] = constraint;
  sign_[active_] = sign;
  side_[constraint] = sign > 0 ? -1 : 1;
  ++active_;
}

void ActiveSet::drop(std::size_t index) noexcept {
  side_[row_[index]] = 0;
  --active_;
  for (std::size_t i = index; i < active_; ++i) {
    row_[i] = row_[i + 1];
    sign_[i] = sign_[i + 1];
    multiplier_[i] = multiplier_[i + 1];
  }
  for (std::size_t k = 0; k <= active_; ++k) {
    double* column = &triangle_[k * capacity_];
    std::copy(column + std::max(k, index + 1), column + active_ + 1, column + std::max(k, index + 1) - 1);
  }
  // Column k of the triangle now begins one row too high.
  for (std::size_t k = index; k < active_; ++k) {
    double* column = &triangle_[k + k * capacity_];
    const double length = std::hypot(column[0], column[capacity_]);
    const double cosine = column[0] / length, sine = column[capacity_] / length;
    rotate_columns(column, column + capacity_, active_ - k, cosine, sine);
    rotate_columns(&basis_[k * capacity_], &basis_[(k + 1) * capacity_], size_, cosine, sine);
  }
}

// y = the minimum with all active constraints at their bounds, and their multipliers there.
void ActiveSet::follow_bounds() noexcept {
  for (std::size_t i = 0; i < active_; ++i) bound_[i] = sign_[i] > 0 ? low_[row_[i]] : -high_[row_[i]];
  solve_lower(triangle_.data(), capacity_, active_, bound_.data());
  product(basis_.data(), capacity_, size_, active_, bound_.data(), y_.data());
  std::copy_n(bound_.begin(), active_, multiplier_.begin());
  solve_lower_transposed(triangle_.data(), capacity_, active_, multiplier_.data());
}

}  // namespace robotskin::control
