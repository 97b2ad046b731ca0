// SPDX-License-Identifier: Apache-2.0
// Random programmes: the active set's answer keeps the limits and has multipliers that prove it best, whatever was
// guessed; where limits exclude each other there is none, and no search takes more steps than its budget. Usage:
// check_active_set SEED PROGRAMMES.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "check.hpp"
#include "control/active_set.hpp"
#include "control/dense_kernels.hpp"

using namespace robotskin;

namespace {

constexpr std::size_t largest_size = 32, largest_constraints = 64;
constexpr double tolerance = 1e-7;

double uniform(Random& random) {
  return 2 * static_cast<double>(random.below(1U << 30)) / (1U << 30) - 1;
}

std::vector<double> values(Random& random, std::size_t count) {
  std::vector<double> all(count);
  for (double& value : all) value = uniform(random);
  return all;
}

struct Programme {
  std::size_t size, constraints;
  std::vector<double> hessian, factor, matrix, low, high, best;  // best: of all x, in no limits

  // Few strong directions in the hessian, as of a task with few rows; all limits allow one common point.
  explicit Programme(Random& random)
      : size(1 + random.below(largest_size)), constraints(random.below(largest_constraints + 1)) {
    const std::size_t strong = 1 + random.below(size);
    const std::vector<double> rows = values(random, strong * size);
    hessian.assign(size * size, 0.0);
    for (std::size_t i = 0; i < size; ++i)
      for (std::size_t k = 0; k < size; ++k) {
        for (std::size_t r = 0; r < strong; ++r) hessian[i + k * size] += rows[r + i * strong] * rows[r + k * strong];
        if (i == k) hessian[i + k * size] += 1e-3;
      }
    factor = hessian;
    CHECK(control::factorise(factor.data(), size, size));
    matrix = values(random, constraints * size);
    const std::vector<double> allowed = values(random, size);
    best = values(random, size);
    for (double& value : best) value *= 10;
    for (std::size_t i = 0; i < constraints; ++i) {
      const double middle = row_times(i, allowed), room = random.below(4) == 0 ? 0 : std::abs(uniform(random));
      low.push_back(middle - room);
      high.push_back(random.below(3) == 0 ? 1e20 : middle + std::abs(uniform(random)));
    }
  }

  double row_times(std::size_t i, const std::vector<double>& x) const {
    double sum = 0;
    for (std::size_t k = 0; k < size; ++k) sum += matrix[i + k * constraints] * x[k];
    return sum;
  }

  control::ActiveSetOutcome solve(control::ActiveSet& solver, std::vector<double>& x, std::vector<std::int8_t>& side,
                                  control::StepBudget& budget) const {
    x = best;
    return solver.solve(
        {size, constraints, factor.data(), size, matrix.data(), constraints, low.data(), high.data(), tolerance},
        x.data(), side.data(), budget);
  }
  // Steps that the best x took.
  std::size_t solve(control::ActiveSet& solver, std::vector<double>& x, std::vector<std::int8_t>& side) const {
    control::StepBudget budget{.most = 100'000};
    CHECK(solve(solver, x, side, budget) == control::ActiveSetOutcome::best);
    return budget.taken;
  }

  std::vector<double> gradient(const std::vector<double>& x) const {
    std::vector<double> slope(size, 0.0);
    for (std::size_t k = 0; k < size; ++k)
      for (std::size_t i = 0; i < size; ++i) slope[i] += hessian[i + k * size] * (x[k] - best[k]);
    return slope;
  }
};

// Least squares by Gram-Schmidt, twice over: the multipliers with which the met limits make up the gradient.
std::vector<double> multipliers(const Programme& one, const std::vector<std::size_t>& met, std::vector<double>& rest) {
  std::vector<std::vector<double>> unit, share;  // unit k = sum over i of share[k][i] times the normal of met[i]
  for (std::size_t k = 0; k < met.size(); ++k) {
    std::vector<double> normal(one.size), own(met.size(), 0.0);
    for (std::size_t i = 0; i < one.size; ++i) normal[i] = one.matrix[met[k] + i * one.constraints];
    own[k] = 1;
    for (int twice = 0; twice < 2; ++twice)
      for (std::size_t j = 0; j < k; ++j) {
        double along = 0;
        for (std::size_t i = 0; i < one.size; ++i) along += normal[i] * unit[j][i];
        for (std::size_t i = 0; i < one.size; ++i) normal[i] -= along * unit[j][i];
        for (std::size_t i = 0; i < met.size(); ++i) own[i] -= along * share[j][i];
      }
    double length = 0;
    for (const double value : normal) length += value * value;
    CHECK(length > 1e-20);  // the met limits are independent
    for (double& value : normal) value /= std::sqrt(length);
    for (double& value : own) value /= std::sqrt(length);
    unit.push_back(normal);
    share.push_back(own);
  }
  std::vector<double> result(met.size(), 0.0);
  for (std::size_t k = 0; k < met.size(); ++k) {
    double along = 0;
    for (std::size_t i = 0; i < one.size; ++i) along += rest[i] * unit[k][i];
    for (std::size_t i = 0; i < one.size; ++i) rest[i] -= along * unit[k][i];
    for (std::size_t i = 0; i < met.size(); ++i) result[i] += along * share[k][i];
  }
  return result;
}

void check_best(const Programme& one, const std::vector<double>& x, const std::vector<std::int8_t>& side) {
  std::vector<std::size_t> met;
  for (std::size_t i = 0; i < one.constraints; ++i) {
    const double value = one.row_times(i, x);
    CHECK(value >= one.low[i] - 2 * tolerance && value <= one.high[i] + 2 * tolerance);
    if (side[i] == 0) continue;
    CHECK(std::abs(value - (side[i] < 0 ? one.low[i] : one.high[i])) < 2 * tolerance);
    met.push_back(i);
  }
  std::vector<double> rest = one.gradient(x);
  double largest = 1e-3;
  for (const double value : rest) largest = std::max(largest, std::abs(value));
  const std::vector<double> force = multipliers(one, met, rest);
  for (const double value : rest) CHECK(std::abs(value) < 1e-6 * largest);
  double strongest = largest;
  for (const double value : force) strongest = std::max(strongest, std::abs(value));
  for (std::size_t i = 0; i < met.size(); ++i) CHECK(-side[met[i]] * force[i] > -1e-6 * strongest);
}

}  // namespace

int main(int count, char** arguments) {
  Random random(argument(count, arguments, 1, 1));
  const std::uint64_t programmes = argument(count, arguments, 2, 1000);
  control::ActiveSet solver(largest_size, largest_constraints);
  std::uint64_t limited = 0, guessed_steps = 0, cold_steps = 0;
  for (std::uint64_t i = 0; i < programmes; ++i) {
    const Programme one(random);
    std::vector<double> x, again, otherwise;
    std::vector<std::int8_t> side(one.constraints, 0);
    const std::size_t steps = one.solve(solver, x, side);
    check_best(one, x, side);
    limited += std::ranges::count(side, 0) < static_cast<std::ptrdiff_t>(one.constraints);
    cold_steps += steps;

    std::vector<std::int8_t> guess = side;
    guessed_steps += one.solve(solver, again, guess);
    for (std::int8_t& one_side : guess) one_side = static_cast<std::int8_t>(static_cast<int>(random.below(3)) - 1);
    one.solve(solver, otherwise, guess);
    check_best(one, otherwise, guess);
    if (steps > 0) {  // what a search has found when its budget ends is a better guess than none
      std::vector<std::int8_t> found(one.constraints, 0);
      std::vector<double> early;
      control::StepBudget budget{.most = random.below(steps)};
      CHECK(one.solve(solver, early, found, budget) == control::ActiveSetOutcome::unfinished);
      CHECK(budget.taken == budget.most);
      one.solve(solver, early, found);
      check_best(one, early, found);
    }
    for (std::size_t k = 0; k < one.size; ++k) {
      CHECK(std::abs(again[k] - x[k]) < 1e-5);
      CHECK(std::abs(otherwise[k] - x[k]) < 1e-5);
    }
    if (one.constraints < 2) continue;
    Programme none = one;  // the second limit now contradicts the first
    for (std::size_t k = 0; k < one.size; ++k) none.matrix[1 + k * one.constraints] = none.matrix[k * one.constraints];
    none.low[1] = none.high[0] < 1e19 ? none.high[0] + 1 : none.low[0] + 1;
    none.high[1] = none.low[1] + 1;
    none.high[0] = none.low[1] - 1;
    control::StepBudget budget{.most = 100'000};
    CHECK(none.solve(solver, x, side, budget) == control::ActiveSetOutcome::none);
  }
  CHECK(limited > programmes / 2);
  CHECK(guessed_steps < cold_steps);
  std::printf("%llu steps without a guess, %llu with the right one\n", static_cast<unsigned long long>(cold_steps),
              static_cast<unsigned long long>(guessed_steps));
}
