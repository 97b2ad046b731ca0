// SPDX-License-Identifier: Apache-2.0
#include "control/active_set.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "control/dense_kernels.hpp"

namespace robotskin::control {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
// Share of a normal's square that has to be independent of the active ones for a step along it. Where the Hessian is
// nearly singular, normals differ by as little as 1e-14 that do exclude each other's minimum. More for what may be
// missed by rounding alone, as a step along the little that is left would carry that far off, and for a guess.
constexpr double independent = 1e-19;
constexpr double independent_rounded = 1e-12;
constexpr double independent_guess = 1e-8;
// A shorter normal, against the longest, belongs to a constraint on which nothing has an influence any more.
constexpr double shortest = 1e-10;
// By how many tolerances a constraint may be missed for its rounding, if the active ones make it up or if it was added
// so often that constraints take turns.
constexpr double rounding = 1000;
constexpr int most_refined = 4;  // attempts, before such a constraint is left out
constexpr std::uint8_t most_added = 4;

}  // namespace

ActiveSet::ActiveSet(std::size_t largest_size, std::size_t largest_constraints)
    : capacity_(largest_size),
      room_(largest_constraints),
      normals_(room_ * capacity_),
      basis_(capacity_ * capacity_),
      triangle_(capacity_ * capacity_),
      row_(capacity_),
      sign_(capacity_),
      side_(room_),
      void_(room_),
      added_(room_) {
  for (auto* values : {&length_, &low_, &high_, &value_}) values->resize(room_);
  for (auto* values : {&y_, &multiplier_, &bound_, &normal_, &turned_, &step_, &share_}) values->resize(capacity_);
}

ActiveSetOutcome ActiveSet::solve(const Problem& problem, double* x, std::int8_t* side, StepBudget& budget) noexcept {
  size_ = problem.size;
  constraints_ = problem.constraints;
  if (size_ > capacity_ || constraints_ > room_) return ActiveSetOutcome::none;
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
  ActiveSetOutcome outcome = search(problem.tolerance, shortest * longest, budget);
  if (outcome == ActiveSetOutcome::none) {  // perhaps for a guess that left it badly conditioned
    std::ranges::fill(side_, std::int8_t{0});
    outcome = search(problem.tolerance, shortest * longest, budget);
  }
  if (outcome == ActiveSetOutcome::none) return outcome;
  std::copy_n(side_.begin(), constraints_, side);
  solve_lower_transposed(problem.factor, problem.factor_stride, size_, y_.data());
  bool finite = true;
  for (std::size_t i = 0; i < size_; ++i) finite = std::isfinite(x[i] += y_[i]) && finite;
  return finite ? outcome : ActiveSetOutcome::none;
}

ActiveSetOutcome ActiveSet::search(double tolerance, double least_length, StepBudget& budget) noexcept {
  for (auto* values : {&void_, &added_}) std::fill_n(values->begin(), constraints_, std::uint8_t{0});
  if (!start_from_guess(least_length, budget)) return ActiveSetOutcome::unfinished;
  bool exact = true;  // y_ is free of what many steps round
  int refined = 0;
  for (;;) {
    product(normals_.data(), room_, constraints_, size_, y_.data(), value_.data());
    std::size_t worst = constraints_;
    double miss = 0, farthest = 0, sign = 1;
    for (std::size_t i = 0; i < constraints_; ++i) {
      const double below = low_[i] - value_[i], above = value_[i] - high_[i], own = std::max(below, above);
      if (!(own > tolerance) || !(own > farthest * length_[i]) || side_[i] != 0 || void_[i] != 0 ||
          length_[i] < least_length)
        continue;
      farthest = own / length_[i];
      miss = own;
      worst = i;
      sign = below > above ? 1 : -1;
    }
    if (worst == constraints_) {
      if (exact) return ActiveSetOutcome::best;
      follow_bounds();
      exact = true;
      continue;
    }
    const bool rounded = miss <= rounding * tolerance;
    if (rounded && added_[worst] >= most_added) {
      void_[worst] = 1;
      continue;
    }
    added_[worst] = static_cast<std::uint8_t>(std::min(added_[worst] + 1, 255));
    const ActiveSetOutcome met = meet(worst, sign, miss, rounded ? independent_rounded : independent, budget);
    if (met == ActiveSetOutcome::unfinished) return met;
    if (met == ActiveSetOutcome::none) {  // the active ones make it up; what is missed may be what they round
      if (!rounded) return met;
      if (exact || ++refined > most_refined) void_[worst] = 1;
      follow_bounds();
      exact = true;
      continue;
    }
    exact = false;
  }
}

// Moves along the constraint's normal until it is met, dropping active ones that stop pushing on the way. `least` is
// the share of its square that has to be independent of them for that.
ActiveSetOutcome ActiveSet::meet(std::size_t constraint, double sign, double miss, double least,
                                 StepBudget& budget) noexcept {
  double along = turn(constraint, sign);
  double multiplier = 0;
  for (;;) {
    if (!budget.take()) return ActiveSetOutcome::unfinished;
    divide_share();
    double partial = infinity;  // until the multiplier of an active constraint is used up
    std::size_t blocking = active_;
    for (std::size_t i = 0; i < active_; ++i)
      if (share_[i] > 0 && multiplier_[i] < partial * share_[i]) {
        partial = multiplier_[i] / share_[i];
        blocking = i;
      }
    const bool moves = active_ < size_ && along > least * length_[constraint] * length_[constraint];
    const double whole = moves ? miss / along : infinity;
    const double length = std::min(partial, whole);
    if (length == infinity) return ActiveSetOutcome::none;
    multiplier += length;
    for (std::size_t i = 0; i < active_; ++i) multiplier_[i] = std::max(multiplier_[i] - length * share_[i], 0.0);
    if (moves) {
      product(&basis_[active_ * capacity_], capacity_, size_, size_ - active_, &turned_[active_], step_.data());
      if (length > 0)
        for (std::size_t i = 0; i < size_; ++i) y_[i] += length * step_[i];
    }
    if (whole <= partial) {
      add(constraint, sign);
      multiplier_[active_ - 1] = multiplier;
      return ActiveSetOutcome::best;
    }
    if (moves) miss -= length * along;
    drop(blocking);
    along += turned_[active_] * turned_[active_];
  }
}

// The minimum under those of the guessed constraints that push. False if the budget ended.
bool ActiveSet::start_from_guess(double least_length, StepBudget& budget) noexcept {
  active_ = 0;
  for (std::size_t k = 0; k < size_; ++k) {
    std::fill_n(&basis_[k * capacity_], size_, 0.0);
    basis_[k + k * capacity_] = 1;
  }
  bool within = true;
  for (std::size_t i = 0; i < constraints_; ++i) {
    if (side_[i] == 0 || !within) continue;  // what is left of the guess when the budget ends stays one
    const double sign = side_[i] < 0 ? 1 : -1;
    side_[i] = 0;
    if (active_ == size_ || length_[i] < least_length) continue;
    const double along = turn(i, sign);
    if (along <= independent_guess * length_[i] * length_[i] || !(within = budget.take())) continue;
    product(&basis_[active_ * capacity_], capacity_, size_, size_ - active_, &turned_[active_], step_.data());
    add(i, sign);
  }
  for (;;) {
    find_multipliers();
    const auto end = multiplier_.begin() + static_cast<std::ptrdiff_t>(active_);
    const auto least = std::min_element(multiplier_.begin(), end);
    if (least == end || *least >= 0 || !(within = within && budget.take())) break;
    drop(static_cast<std::size_t>(least - multiplier_.begin()));
  }
  product(basis_.data(), capacity_, size_, active_, bound_.data(), y_.data());
  return within;
}

// turned = the constraint's normal along the basis. Returns the square of what is independent of the active ones.
double ActiveSet::turn(std::size_t constraint, double sign) noexcept {
  for (std::size_t k = 0; k < size_; ++k) normal_[k] = sign * normals_[constraint + k * room_];
  transposed_product(basis_.data(), capacity_, size_, size_, normal_.data(), turned_.data());
  double along = 0;
  for (std::size_t k = active_; k < size_; ++k) along += turned_[k] * turned_[k];
  return along;
}

// share = how the active normals make up what of the turned one depends on them.
void ActiveSet::divide_share() noexcept {
  std::copy_n(turned_.begin(), active_, share_.begin());
  solve_upper(triangle_.data(), capacity_, active_, share_.data());
}

// After turn, and step = basis times the independent part: the basis turns so that its next column is that part.
void ActiveSet::add(std::size_t constraint, double sign) noexcept {
  double* rest = &turned_[active_];
  double* column = &basis_[active_ * capacity_];
  double along = 0;
  for (std::size_t k = 0; k < size_ - active_; ++k) along += rest[k] * rest[k];
  const double diagonal = *rest > 0 ? -std::sqrt(along) : std::sqrt(along);
  const double factor = 1 / (along - diagonal * *rest);
  for (std::size_t i = 0; i < size_; ++i) step_[i] = factor * (step_[i] - diagonal * column[i]);
  *rest -= diagonal;
  subtract_outer(column, capacity_, size_, size_ - active_, step_.data(), rest);
  std::copy_n(turned_.begin(), active_, &triangle_[active_ * capacity_]);
  triangle_[active_ + active_ * capacity_] = diagonal;
  row_[active_] = constraint;
  sign_[active_] = sign;
  side_[constraint] = sign > 0 ? -1 : 1;
  ++active_;
}

// Also turns `turned` with the basis.
void ActiveSet::drop(std::size_t index) noexcept {
  side_[row_[index]] = 0;
  --active_;
  for (std::size_t i = index; i < active_; ++i) {
    row_[i] = row_[i + 1];
    sign_[i] = sign_[i + 1];
    multiplier_[i] = multiplier_[i + 1];
  }
  // Column k of the triangle, once column k + 1, ends one row too low.
  for (std::size_t k = index; k < active_; ++k)
    std::copy_n(&triangle_[(k + 1) * capacity_], k + 2, &triangle_[k * capacity_]);
  for (std::size_t k = index; k < active_; ++k) {
    double* corner = &triangle_[k + k * capacity_];
    const double length = std::sqrt(corner[0] * corner[0] + corner[1] * corner[1]);
    const double cosine = corner[0] / length, sine = corner[1] / length;
    const auto rotate = [&](double* pair) {
      const double first = pair[0];
      pair[0] = cosine * first + sine * pair[1];
      pair[1] = cosine * pair[1] - sine * first;
    };
    for (std::size_t j = k; j < active_; ++j) rotate(&triangle_[k + j * capacity_]);
    rotate(&turned_[k]);
    rotate_columns(&basis_[k * capacity_], &basis_[(k + 1) * capacity_], size_, cosine, sine);
  }
}

// bound = where all active constraints are at their bounds, along the basis, and their multipliers there.
void ActiveSet::find_multipliers() noexcept {
  for (std::size_t i = 0; i < active_; ++i) bound_[i] = sign_[i] > 0 ? low_[row_[i]] : -high_[row_[i]];
  solve_upper_transposed(triangle_.data(), capacity_, active_, bound_.data());
  std::copy_n(bound_.begin(), active_, multiplier_.begin());
  solve_upper(triangle_.data(), capacity_, active_, multiplier_.data());
}

// y = the minimum with all active constraints at their bounds, improved once for what the triangle rounds.
void ActiveSet::follow_bounds() noexcept {
  find_multipliers();
  product(basis_.data(), capacity_, size_, active_, bound_.data(), y_.data());
  product(normals_.data(), room_, constraints_, size_, y_.data(), value_.data());
  for (std::size_t i = 0; i < active_; ++i) {
    const double missed = sign_[i] > 0 ? low_[row_[i]] - value_[row_[i]] : value_[row_[i]] - high_[row_[i]];
    bound_[i] = missed;
    multiplier_[i] = std::max(multiplier_[i], 0.0);
  }
  solve_upper_transposed(triangle_.data(), capacity_, active_, bound_.data());
  product(basis_.data(), capacity_, size_, active_, bound_.data(), step_.data());
  for (std::size_t i = 0; i < size_; ++i) y_[i] += step_[i];
}

}  // namespace robotskin::control
