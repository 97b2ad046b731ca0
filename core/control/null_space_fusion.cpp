// SPDX-License-Identifier: Apache-2.0
#include "control/null_space_fusion.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <string>

#include "control/control_error.hpp"

namespace robotskin::control {
namespace {

using Matrix = Eigen::MatrixXd;
constexpr int block = NullSpaceFusion::block_rows;
using Gram = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, block, block>;

}  // namespace

struct NullSpaceFusion::Workspace {
  Workspace(std::size_t joint_count, std::size_t largest_rows, Inverse which, Damping damped)
      : inverse(which),
        damping(damped),
        capacity(static_cast<Eigen::Index>(largest_rows)),
        joints(static_cast<Eigen::Index>(joint_count)),
        factor(joints, joints),
        rows(joints, block),
        direction(joints, capacity),
        protection(capacity),
        torque(joints),
        sum(joints),
        beside(joints),
        missing(block) {}

  Inverse inverse;
  Damping damping;
  Eigen::Index capacity, joints;
  Matrix factor;               // L of M = L L^T, in place
  Matrix rows;                 // (n, block) columns L^-1 J^T, then what of them is not protected yet
  Matrix direction;            // (n, taken) unit vectors
  Eigen::VectorXd protection;  // (taken) 0 to 1
  Eigen::Index taken = 0;
  Eigen::VectorXd torque, sum;
  Eigen::VectorXd beside;   // (n) L^-1 of what moves the robot besides
  Eigen::VectorXd missing;  // (block) acceleration that rows lack
  Eigen::SelfAdjointEigenSolver<Gram> solver{Gram::Zero(block, block).eval()};

  // v <- N v, where N is the product of all (1 - protection direction direction^T) so far.
  template <typename Vector>
  void project(Vector&& v) const noexcept {
    // [Cheng19 eq. 20], never made as a matrix
    for (Eigen::Index i = taken; i-- > 0;) v -= protection[i] * direction.col(i).dot(v) * direction.col(i);
  }

  // `wanted` (count) acceleration of the rows, null: none is asked for.
  bool take(Eigen::Index count, const double* wanted) noexcept {
    if (wanted != nullptr)
      for (Eigen::Index i = 0; i < count; ++i) missing[i] = wanted[i] - rows.col(i).dot(beside) - rows.col(i).dot(sum);
    for (Eigen::Index i = 0; i < count; ++i) project(rows.col(i));
    Gram gram(count, count);
    for (Eigen::Index i = 0; i < count; ++i)
      for (Eigen::Index k = 0; k <= i; ++k) gram(i, k) = gram(k, i) = rows.col(i).dot(rows.col(k));
    solver.compute(gram);
    if (solver.info() != Eigen::Success) return false;
    for (Eigen::Index i = 0; i < count; ++i) {
      const double square = std::max(solver.eigenvalues()[i], 0.0);
      const double singular = std::sqrt(square);
      if (singular < 1e-9) continue;  // protects nothing
      if (taken == capacity) return false;
      double damped = 0;
      if (singular < damping.threshold) {
        const double ratio = singular / damping.threshold;
        damped = damping.damping * damping.damping * (1 - ratio * ratio);
      }
      direction.col(taken).setZero();
      for (Eigen::Index k = 0; k < count; ++k) direction.col(taken) += solver.eigenvectors()(k, i) * rows.col(k);
      direction.col(taken).normalize();
      protection[taken] = square / (square + damped);
      if (wanted != nullptr) {
        double along = 0;
        for (Eigen::Index k = 0; k < count; ++k) along += solver.eigenvectors()(k, i) * missing[k];
        sum += along * singular / (square + damped) * direction.col(taken);
      }
      ++taken;
    }
    return true;
  }

  bool fuse(std::span<const FusionLevel> levels) noexcept {
    taken = 0;
    sum.setZero();
    for (std::size_t level = 0; level < levels.size(); ++level) {
      const FusionLevel& own = levels[level];
      const bool accelerates = !own.acceleration.empty();
      if (!accelerates) {
        torque = Eigen::Map<const Eigen::VectorXd>(own.torque.data(), joints);
        if (inverse == Inverse::dynamically_consistent) factor.triangularView<Eigen::Lower>().solveInPlace(torque);
        project(torque);
        sum += torque;                          // [Cheng19 eq. 19]
        if (level + 1 == levels.size()) break;  // no level is below
      }
      const auto count = static_cast<Eigen::Index>(own.rows.size()) / joints;
      for (Eigen::Index first = 0; first < count; first += block) {
        const Eigen::Index size = std::min<Eigen::Index>(block, count - first);
        for (Eigen::Index i = 0; i < size; ++i)
          rows.col(i) = Eigen::Map<const Eigen::VectorXd>(own.rows.data() + (first + i) * joints, joints);
        if (inverse == Inverse::dynamically_consistent)
          factor.triangularView<Eigen::Lower>().solveInPlace(rows.leftCols(size));
        if (!take(size, accelerates ? own.acceleration.data() + first : nullptr)) return false;
      }
    }
    if (inverse == Inverse::dynamically_consistent) {
      torque.noalias() = factor.triangularView<Eigen::Lower>() * sum;
      sum.swap(torque);
    }
    return true;
  }
};

NullSpaceFusion::NullSpaceFusion(std::size_t joint_count, std::size_t largest_rows, Inverse inverse, Damping damping)
    : workspace_(std::make_unique<Workspace>(joint_count, largest_rows, inverse, damping)) {
  for (const double value : {damping.threshold, damping.damping})
    if (!(value > 0) || !std::isfinite(value))
      throw ControlError("null-space fusion: damping " + std::to_string(value) + " must be finite and greater than 0");
}

NullSpaceFusion::~NullSpaceFusion() = default;
NullSpaceFusion::NullSpaceFusion(NullSpaceFusion&&) noexcept = default;
NullSpaceFusion& NullSpaceFusion::operator=(NullSpaceFusion&&) noexcept = default;

bool NullSpaceFusion::fuse(std::span<const double> mass, std::span<const FusionLevel> levels, std::span<double> fused,
                           std::span<const double> beside) noexcept {
  Workspace& work = *workspace_;
  const auto joints = static_cast<std::size_t>(work.joints);
  if (fused.size() != joints || (!beside.empty() && beside.size() != joints)) return false;
  for (const FusionLevel& level : levels) {
    if (level.torque.size() != joints || level.rows.size() % joints != 0) return false;
    if (!level.acceleration.empty() &&
        (level.acceleration.size() * joints != level.rows.size() || work.inverse != Inverse::dynamically_consistent))
      return false;
  }
  if (work.inverse == Inverse::dynamically_consistent) {
    if (mass.size() != joints * joints) return false;
    work.factor = Eigen::Map<const Matrix>(mass.data(), work.joints, work.joints);  // symmetric
    const Eigen::LLT<Eigen::Ref<Matrix>> cholesky(work.factor);
    if (cholesky.info() != Eigen::Success) return false;
    work.beside.setZero();
    if (!beside.empty()) {
      work.beside = Eigen::Map<const Eigen::VectorXd>(beside.data(), work.joints);
      work.factor.triangularView<Eigen::Lower>().solveInPlace(work.beside);
    }
  }
  if (!work.fuse(levels)) return false;
  std::copy_n(work.sum.data(), joints, fused.begin());
  return work.sum.allFinite();
}

}  // namespace robotskin::control
