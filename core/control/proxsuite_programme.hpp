// A small quadratic programme given to ProxSuite. Its headers are compiled for one file alone.
#pragma once

#include <cstddef>
#include <memory>

namespace robotskin::control {

class ProxsuiteProgramme {
 public:
  // For `size` variables and `constraints` constraints; `tolerance` of its limits and of its optimality.
  ProxsuiteProgramme(std::size_t size, std::size_t constraints, double tolerance);
  ~ProxsuiteProgramme();
  ProxsuiteProgramme(ProxsuiteProgramme&&) noexcept;
  ProxsuiteProgramme& operator=(ProxsuiteProgramme&&) noexcept;

  // x (size): minimum of x^T hessian x / 2 + gradient^T x with low <= matrix x <= high. False, with x as it was, if
  // ProxSuite found none. Matrices are stored by columns; those of `matrix` are `stride` doubles apart, and those from
  // `columns` on are zero. May allocate.
  [[nodiscard]] bool solve(const double* hessian, const double* gradient, const double* matrix, std::size_t stride,
                           std::size_t columns, const double* low, const double* high, double* x) noexcept;

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace robotskin::control
