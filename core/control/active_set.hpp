// SPDX-License-Identifier: Apache-2.0
// A small quadratic programme whose minimum without constraints is known: the dual active-set method.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "control/step_budget.hpp"

namespace robotskin::control {

// best: x is the minimum. unfinished: the budget ended; x is best under some of the constraints and misses others.
// none: the constraints exclude each other.
enum class ActiveSetOutcome : std::uint8_t { best, unfinished, none };

// Goldfarb and Idnani 1983: from the minimum under the constraints that are guessed to be met, violated constraints are
// added one by one, and dropped again where they no longer push. It ends exactly, after about as many steps as the
// guess was wrong about constraints.
class ActiveSet {
 public:
  // Room for `largest_size` variables and as many constraints as `largest_constraints`.
  ActiveSet(std::size_t largest_size, std::size_t largest_constraints);

  // All matrices are stored by columns; a stride is what lies between two columns.
  struct Problem {
    std::size_t size, constraints;
    const double* factor;  // lower triangle L (size, size) of the Hessian L L^T
    std::size_t factor_stride;
    const double* matrix;  // (constraints, size)
    std::size_t matrix_stride;
    const double *low, *high;  // (constraints) low <= matrix x <= high
    double tolerance;          // by which a constraint may be missed; a thousand times that where it rounds
  };
  // x (size): in, the unconstrained minimum; out, the constrained one. side (constraints): in, a guess of what is met,
  // -1 the lower bound, 1 the upper one, 0 none; out, what is, or where the search stopped. A step of `budget` is one
  // constraint added or dropped. Allocates nothing.
  [[nodiscard]] ActiveSetOutcome solve(const Problem& problem, double* x, std::int8_t* side,
                                       StepBudget& budget) noexcept;

 private:
  ActiveSetOutcome search(double tolerance, double least_length, StepBudget& budget) noexcept;
  bool start_from_guess(double least_length, StepBudget& budget) noexcept;
  ActiveSetOutcome meet(std::size_t constraint, double sign, double miss, double least, StepBudget& budget) noexcept;
  double turn(std::size_t constraint, double sign) noexcept;
  void divide_share() noexcept;
  void add(std::size_t constraint, double sign) noexcept;
  void drop(std::size_t index) noexcept;
  void find_multipliers() noexcept;
  void follow_bounds() noexcept;

  std::size_t capacity_, room_;     // variables, constraints
  std::vector<double> normals_;     // (constraints, size) in y = L^T (x - unconstrained minimum)
  std::vector<double> length_;      // (constraints) of the normals
  std::vector<double> low_, high_;  // (constraints) bounds of normals y
  std::vector<double> value_;       // (constraints) normals y
  std::vector<double> basis_;       // (size, size) orthogonal; its first columns span the active normals
  std::vector<double> triangle_;    // (active, active) upper: the active normals are basis triangle
  std::vector<double> y_, multiplier_, bound_, normal_, turned_, step_, share_;
  std::vector<std::size_t> row_;     // (active) constraint
  std::vector<double> sign_;         // (active) 1: at its lower bound
  std::vector<std::int8_t> side_;    // (constraints)
  std::vector<std::uint8_t> void_;   // (constraints) those that are missed by rounding alone
  std::vector<std::uint8_t> added_;  // (constraints) how often, in this search
  std::size_t size_ = 0, constraints_ = 0, active_ = 0;
};

}  // namespace robotskin::control
