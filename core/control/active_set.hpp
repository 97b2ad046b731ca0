// A small quadratic programme whose minimum without constraints is known: the dual active-set method.
#pragma once

#include <cstddef>
#include <memory>

namespace robotskin::control {

// Goldfarb and Idnani 1983: from the unconstrained minimum, constraints that are violated are added one by one, and
// dropped again where they no longer push. Where few limits are met, as by a robot, it ends after as few steps,
// exactly.
class ActiveSet {
 public:
  // Room for `largest_size` variables and as many constraints as `largest_constraints`.
  ActiveSet(std::size_t largest_size, std::size_t largest_constraints);
  ~ActiveSet();
  ActiveSet(ActiveSet&&) noexcept;
  ActiveSet& operator=(ActiveSet&&) noexcept;

  // All matrices are stored by columns; a stride is what lies between two columns.
  struct Problem {
    std::size_t size, constraints;
    const double* factor;  // lower triangle L (size, size) of the Hessian L L^T
    std::size_t factor_stride;
    const double* matrix;  // (constraints, size)
    std::size_t matrix_stride;
    const double *low, *high;  // (constraints) low <= matrix x <= high
    double tolerance;          // by which a constraint may be missed
  };
  // x (size): in, the unconstrained minimum; out, the constrained one. False, with x undefined, if there is none or too
  // many steps are needed. Allocates nothing.
  [[nodiscard]] bool solve(const Problem& problem, double* x) noexcept;
  std::size_t steps() const noexcept;  // of the last solve

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace robotskin::control
