// SPDX-License-Identifier: Apache-2.0
// A hierarchy of least-squares problems within limits: each level does its best in what higher ones have left.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "control/active_set.hpp"
#include "control/step_budget.hpp"

namespace robotskin::control {

// One level: rows x as near as possible to within low and high; where these are equal, the row is an equation. Rows are
// as dear as the caller scales them, in any unit: the squares of what is missed are added up.
struct QpLevel {
  const double* rows;                 // (count, n), by columns that lie `count` doubles apart
  std::span<const double> low, high;  // (count) low <= high; infinite where there is no bound
};

// What must hold, exactly: low <= matrix x <= high.
struct QpLimits {
  const double* matrix;               // (m, n), by columns that lie m doubles apart
  std::span<const double> low, high;  // (m)
};

// Level k: the x nearest to what the level wants, and of these the least (`least_effort` times |x|^2 is added to every
// level), within the limits and without changing what higher levels have. The level's equations then stand as they are
// for lower ones, and its ranges must be missed by no more. Where no limit is met that is one Cholesky factor; from
// there an active set adds the limits that are met, beginning with those of the last solve.
//
// The work is counted in steps of the active sets. Where the budget ends, the levels so far are exact; the one that it
// ends in, and those below, go from there straight towards their best under the limits that they know, as far as all
// limits allow. x keeps all limits at any budget.
class HierarchicalQp {
 public:
  struct Sizes {
    std::size_t variables;     // n
    std::size_t limits;        // m
    std::size_t largest_rows;  // of one level
    std::size_t levels;
    std::size_t ranges = 0;  // rows of all levels that are no equations
  };
  explicit HierarchicalQp(const Sizes& sizes);

  // `x` (n): in, a point within the limits; out, the answer. False if a size is wrong or numbers are not finite.
  // Allocates nothing.
  [[nodiscard]] bool solve(const QpLimits& limits, std::span<const QpLevel> levels, StepBudget& budget,
                           std::span<double> x) noexcept;

  // Of the last solve.
  std::span<const double> missed(std::size_t level) const noexcept;  // (count) rows x - what was wanted, 0 in a range
  std::size_t constrained() const noexcept { return constrained_; }  // levels that met a limit
  std::size_t finished() const noexcept { return finished_; }        // levels above the one in which the budget ended
  std::size_t claimed() const noexcept { return claimed_; }          // directions claimed by all levels but the last

  // Takes from `step` (n) what would change the equations of the first `levels` levels of the last solve.
  void keep(std::size_t levels, std::span<double> step) noexcept;
  // x += share step, with the largest share, 0 to 1, that keeps all limits; x is where the last solve or move ended.
  double move(std::span<const double> step, std::span<double> x) noexcept;
  // Forgets which limits were met.
  void restart() noexcept;

  static constexpr double tolerance = 1e-6;     // by which limits may be missed, in their own units
  static constexpr double least_effort = 1e-6;  // of |x|^2, against a level's own squared error

 private:
  bool solve_level(const QpLevel& level, std::size_t index, StepBudget& budget, std::span<double> x) noexcept;
  void sort_rows(const QpLevel& level) noexcept;
  void add_ranges(const QpLevel& level, std::span<const double> x) noexcept;
  bool find_minimum(const QpLevel& level, std::span<const double> x) noexcept;
  bool meet_limits(std::int8_t* side, StepBudget& budget) noexcept;
  void record(const QpLevel& level, std::size_t index) noexcept;
  void claim() noexcept;

  double* column(std::size_t k) noexcept { return &turned_[k * stride_]; }
  double* basis(std::size_t k) noexcept { return column(k) + largest_limits_; }

  Sizes sizes_;
  std::size_t largest_limits_, stride_, width_;  // limits with ranges; rows and columns of turned_
  // The limits' matrix and the identity, (largest limits + n) rows, times a basis of n columns: orthonormal, first what
  // higher levels have claimed, then what is left. After these, how far the level misses each of its ranges.
  std::vector<double> turned_;
  std::vector<double> rows_, reduced_;      // (rows, n) the level's equations, and these in the basis of what is left
  std::vector<double> factor_;              // (width, width) lower triangle of the level's Hessian
  std::vector<double> low_, high_, value_;  // (limits) bounds, and matrix x
  std::vector<double> room_low_, room_high_, image_;
  std::vector<double> error_, z_, step_, reflector_, missed_;
  std::vector<std::size_t> row_;  // (rows) of the level: equations, then ranges
  std::vector<std::size_t> missed_count_, claimed_before_;
  std::vector<std::int8_t> side_;  // (levels, limits) that each level met in its last solve
  ActiveSet active_set_;
  std::size_t limits_ = 0, equations_ = 0, ranges_ = 0;  // so far; of the level
  std::size_t claimed_ = 0, constrained_ = 0, finished_ = 0;
};

}  // namespace robotskin::control
