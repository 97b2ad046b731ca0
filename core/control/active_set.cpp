#include "control/active_set.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <vector>

namespace robotskin::control {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
constexpr double infinity = std::numeric_limits<double>::infinity();
// Share of a constraint's normal that has to be independent of the active ones for a step along it.
constexpr double independent = 1e-12;

}  // namespace

// The method works in y = L^T x, where the Hessian is the identity.
struct ActiveSet::Workspace {
  Workspace(Eigen::Index size, Eigen::Index constraints)
      : normals(size, size + 1),
        gram(size, size),
        y(size),
        x(size),
        normal(size),
        step(size),
        dual(size + 1),
        bound(size + 1),
        dual_step(size),
        value(constraints),
        row(static_cast<std::size_t>(size) + 1) {}

  Matrix normals;  // (size, active) in the directions in which their constraints allow y to go
  Matrix gram;     // (active, active), then its factor
  Vector y, x, normal, step, dual, bound, dual_step, value;
  std::vector<Eigen::Index> row;  // (active) of the matrix
  Eigen::Index active = 0;
  std::size_t steps = 0;

  void drop(Eigen::Index index) {
    for (Eigen::Index i = index; i + 1 < active; ++i) {
      normals.col(i) = normals.col(i + 1);
      dual[i] = dual[i + 1];
      bound[i] = bound[i + 1];
      row[static_cast<std::size_t>(i)] = row[static_cast<std::size_t>(i) + 1];
    }
    --active;
  }

  bool is_active(Eigen::Index constraint) const noexcept {
    return std::find(row.begin(), row.begin() + active, constraint) != row.begin() + active;
  }

  // dual_step = the shares of the active normals whose products with these normals it was.
  bool share_out(Eigen::Index size) {
    auto own = normals.topLeftCorner(size, active);
    auto block = gram.topLeftCorner(active, active);
    block.noalias() = own.transpose() * own;
    Eigen::Ref<Matrix> in_place = block;
    const Eigen::LLT<Eigen::Ref<Matrix>> factor(in_place);
    if (factor.info() != Eigen::Success) return false;
    auto share = dual_step.head(active);
    factor.solveInPlace(share);
    return true;
  }

  // Takes away what rounding has left between y and the bounds of the active constraints.
  bool meet_the_bounds(Eigen::Index size) {
    auto own = normals.topLeftCorner(size, active);
    auto share = dual_step.head(active);
    share = bound.head(active);
    share.noalias() -= own.transpose() * y.head(size);
    if (!share_out(size)) return false;
    y.head(size).noalias() += own * share;
    return true;
  }

  // step = the part of normal that is independent of the active normals, dual_step = the others' share in the rest.
  bool split(Eigen::Index size) {
    auto own = normals.topLeftCorner(size, active);
    step.head(size) = normal.head(size);
    if (active == 0) return true;
    auto share = dual_step.head(active);
    share.noalias() = own.transpose() * normal.head(size);
    if (!share_out(size)) return false;
    step.head(size).noalias() -= own * share;
    return true;
  }
};

ActiveSet::ActiveSet(std::size_t largest_size, std::size_t largest_constraints)
    : workspace_(std::make_unique<Workspace>(static_cast<Eigen::Index>(largest_size),
                                             static_cast<Eigen::Index>(largest_constraints))) {}
ActiveSet::~ActiveSet() = default;
ActiveSet::ActiveSet(ActiveSet&&) noexcept = default;
ActiveSet& ActiveSet::operator=(ActiveSet&&) noexcept = default;

std::size_t ActiveSet::steps() const noexcept {
  return workspace_->steps;
}

bool ActiveSet::solve(const Problem& problem, double* solution) noexcept {
  using Strided = Eigen::Map<const Matrix, 0, Eigen::OuterStride<>>;
  Workspace& work = *workspace_;
  const auto size = static_cast<Eigen::Index>(problem.size), count = static_cast<Eigen::Index>(problem.constraints);
  if (size > work.y.size() || count > work.value.size()) return false;
  const Strided factor(problem.factor, size, size,
                       Eigen::OuterStride<>(static_cast<Eigen::Index>(problem.factor_stride)));
  const Strided matrix(problem.matrix, count, size,
                       Eigen::OuterStride<>(static_cast<Eigen::Index>(problem.matrix_stride)));
  const auto lower = factor.triangularView<Eigen::Lower>();

  work.x.head(size) = Eigen::Map<const Vector>(solution, size);
  work.y.head(size).noalias() = lower.transpose() * work.x.head(size);
  work.active = 0;
  const std::size_t most = 10 * problem.size + problem.constraints;
  for (work.steps = 0; work.steps < most;) {
    work.value.head(count).noalias() = matrix * work.x.head(size);
    Eigen::Index worst = -1;
    double miss = problem.tolerance, sign = 1;
    for (Eigen::Index i = 0; i < count; ++i) {
      if (work.is_active(i)) continue;
      const double below = problem.low[i] - work.value[i], above = work.value[i] - problem.high[i];
      if (std::max(below, above) > miss) {
        miss = std::max(below, above);
        worst = i;
        sign = below > above ? 1 : -1;
      }
    }
    if (worst < 0) {
      Eigen::Map<Vector>(solution, size) = work.x.head(size);
      return work.x.head(size).allFinite();
    }
    work.normal.head(size) = sign * matrix.row(worst).transpose();
    auto normal = work.normal.head(size);
    lower.solveInPlace(normal);
    double pressure = 0;  // multiplier of the new constraint
    for (;;) {
      if (++work.steps > most || !work.split(size)) return false;
      double partial = infinity;  // until the multiplier of an active constraint is used up
      Eigen::Index blocking = -1;
      for (Eigen::Index i = 0; i < work.active; ++i)
        if (work.dual_step[i] > 0 && work.dual[i] / work.dual_step[i] < partial) {
          partial = work.dual[i] / work.dual_step[i];
          blocking = i;
        }
      const double along = work.step.head(size).squaredNorm();
      const bool moves = along > independent * normal.squaredNorm() && work.active < size;
      const double whole = moves ? miss / along : infinity;
      const double length = std::min(partial, whole);
      if (length == infinity) return false;  // the constraints exclude each other
      work.dual.head(work.active) -= length * work.dual_step.head(work.active);
      pressure += length;
      if (moves) {
        work.y.head(size) += length * work.step.head(size);
        miss -= length * along;
      }
      if (moves && whole <= partial) {
        work.normals.col(work.active).head(size) = normal;
        work.dual[work.active] = pressure;
        work.row[static_cast<std::size_t>(work.active)] = worst;
        work.bound[work.active] = sign > 0 ? problem.low[worst] : -problem.high[worst];
        ++work.active;
        break;
      }
      work.drop(blocking);
    }
    if (!work.meet_the_bounds(size)) return false;
    work.x.head(size) = work.y.head(size);
    auto x = work.x.head(size);
    lower.transpose().solveInPlace(x);
  }
  return false;
}

}  // namespace robotskin::control
