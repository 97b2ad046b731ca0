// SPDX-License-Identifier: Apache-2.0
// Fusion by strict hierarchy: lower tasks act in the null space of higher ones [Cheng19 eq. 19, 20].
#pragma once

#include <cstddef>
#include <memory>
#include <span>

namespace robotskin::control {

// One level of the hierarchy, the highest first.
struct FusionLevel {
  std::span<const double> torque;  // (n) Nm
  std::span<const double> rows;    // (rows, n) the motions that lower levels must leave alone
  // (rows) what the rows are to have instead of the torque, as far as higher levels leave it; empty: the torque counts.
  std::span<const double> acceleration = {};
};

// Which generalised inverse stands in [Cheng19 eq. 20]. dynamically_consistent, M^-1 J^T (J M^-1 J^T)^-1: lower levels
// cause no acceleration of higher ones, J M^-1 N tau = 0. moore_penrose: J N tau = 0 only, so that nothing is disturbed
// at rest, but motion is.
enum class Inverse : unsigned char { dynamically_consistent, moore_penrose };

// Directions whose singular value s (of J L^-T with M = L L^T, 1/sqrt(kg), or of J, m/rad) is below `threshold` are
// protected by s^2 / (s^2 + d^2) only, d^2 = damping^2 (1 - (s / threshold)^2): the smaller s, the more of a lower task
// passes, at most d^2 / (s^2 + d^2).
struct Damping {
  double threshold = 0.02;
  double damping = 0.02;
};

// N_1 = 1, N_k+1 = N_k (1 - J_k^T J_k^+T) with J_k = J N_k^T, in coordinates L^-1 tau in which the weighted inverse is
// an ordinary one: each level leaves behind the directions, orthonormal within it, that it takes from those below.
class NullSpaceFusion {
 public:
  // Levels of more than block_rows rows are taken block by block: exact, but for damping, which sees one block at once.
  static constexpr std::size_t block_rows = 12;

  // Throws ControlError for a damping that is not positive and finite.
  NullSpaceFusion(std::size_t joint_count, std::size_t largest_rows, Inverse inverse, Damping damping = {});
  ~NullSpaceFusion();
  NullSpaceFusion(NullSpaceFusion&&) noexcept;
  NullSpaceFusion& operator=(NullSpaceFusion&&) noexcept;

  // fused (n) = sum of N_k tau_k, Nm. `mass` (n, n) is the inertia that answers to the torque; not read for
  // moore_penrose. `beside` (n) Nm is what moves the robot besides, where a level asks for accelerations: torques
  // outside of the levels less the torque of no acceleration; empty: none. False if a size is wrong, there are more
  // than largest_rows rows in all, or mass is not positive definite. Allocates nothing.
  [[nodiscard]] bool fuse(std::span<const double> mass, std::span<const FusionLevel> levels, std::span<double> fused,
                          std::span<const double> beside = {}) noexcept;

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace robotskin::control
