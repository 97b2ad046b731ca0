// SPDX-License-Identifier: Apache-2.0
// Fusion by a hierarchy of quadratic programmes: like the null-space hierarchy, and within the robot's limits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "control/acceleration_bounds.hpp"
#include "control/hierarchical_qp.hpp"
#include "control/null_space_fusion.hpp"
#include "control/task.hpp"
#include "model/robot_model.hpp"

namespace robotskin::control {

// acceleration: a joint may go only as fast as it can brake before its position limit, and no faster than its velocity
// limit, both stated for its acceleration. paper: [Cheng19 eq. 27] as printed, bounds on the torque that shrink with
// the distance to the limits; at a limit it forbids even the torque that holds gravity, which is why it is a baseline.
enum class LimitForm : std::uint8_t { acceleration, paper };

struct QuadraticLimits {
  std::vector<double> lower, upper;    // (n) rad
  std::vector<double> velocity;        // (n) rad/s
  std::vector<double> torque;          // (n) Nm
  std::vector<double> braking;         // (n) rad/s^2 on which stopping before a position limit counts
  double margin_rad = 0.02;            // kept from the position limits, at most 5 % of the room between them
  double horizon_s = speed_horizon_s;  // in which a velocity beyond its bound is to come back
  LimitForm form = LimitForm::acceleration;
  double position_rate = 100;  // lambda of [Cheng19 eq. 27], Nm/rad
  double velocity_rate = 100;  // mu of [Cheng19 eq. 27], Nm s/rad
  std::size_t steps = 400;     // solver steps of one tick; to find a torque within all limits, BrakingRoom has its own
  double fade_s = 0.25;        // how long a difference fades that the end of the steps made

  // The limits of the robot's model; every joint brakes with `braking` rad/s^2.
  static QuadraticLimits of(const RobotModel& robot, double braking = 10);
};

// Rows of one programme with others: `acceleration` (rows) is what they are to have, as nearly as `weight` is great.
struct WeightedRows {
  std::span<const double> rows;          // (rows, n)
  std::span<const double> acceleration;  // (rows)
  double weight = 1;                     // of the squared error, 0 or more
};

// How the work of a tick ended.
struct FusionReport {
  std::size_t steps = 0;       // of the solver, in this tick
  std::size_t room_steps = 0;  // of these, to find a torque within all limits
  bool fallback = false;       // the steps, or the time, ended before all levels were exact
  bool by_clock = false;       // it was the time
  bool fade_limited = false;   // a limit forbade that the torque went on without a step
  bool widened = false;        // no torque keeps all limits: those of acceleration gave way
  std::size_t finished = 0;    // levels that are exact, from the highest on
};

// Level k: the torque tau = M a + bias nearest to giving its motions the acceleration that the level's own torque would
// give, J_k M^-1 tau = J_k M^-1 tau_k, without touching what higher levels have, and within the limits: a
// HierarchicalQp in coordinates t = L^-1 tau, M = L L^T.
//
// Where the solver's steps end before its work does, the command still keeps all limits and the levels that are exact
// (the fall-back). In the tick in which that begins or ends the torque stays what it was but for these; the difference
// fades along a smoothstep. While it lasts, the torque follows what the fall-back allows as a low-pass of fade_s / 1.5.
class QuadraticFusion {
 public:
  // Throws ControlError for limits that do not fit the robot. `largest_rows` bounds the rows of all levels together.
  QuadraticFusion(std::size_t joint_count, std::size_t largest_rows, std::size_t levels, QuadraticLimits limits);
  ~QuadraticFusion();
  QuadraticFusion(QuadraticFusion&&) noexcept;
  QuadraticFusion& operator=(QuadraticFusion&&) noexcept;

  // fused (n) Nm, `feedforward` (n) included. `mass` (n, n) is the inertia that answers to torques and `bias` (n) the
  // torque of no acceleration. False if a size is wrong or there is no finite answer. Allocates nothing.
  [[nodiscard]] bool fuse(const TaskInput& input, std::span<const double> mass, std::span<const double> bias,
                          std::span<const double> feedforward, std::span<const FusionLevel> levels,
                          std::span<double> fused) noexcept;

  // All rows in one programme, without a hierarchy: min of the sum of weight |rows a - acceleration|^2 within the
  // limits. The other arguments are those of fuse, and so is what is returned.
  [[nodiscard]] bool fuse_weighted(const TaskInput& input, std::span<const double> mass, std::span<const double> bias,
                                   std::span<const double> feedforward, std::span<const WeightedRows> terms,
                                   std::span<double> fused) noexcept;

  // After fuse: fused += share addition (n) Nm, with the largest share, 0 to 1, that keeps all limits.
  double add_within_limits(std::span<const double> addition, std::span<double> fused) noexcept;
  // The next tick has no tick before it: nothing fades.
  void restart() noexcept;
  // How many solver steps a tick may take from now on.
  void set_steps(std::size_t steps) noexcept;

  const FusionReport& report() const noexcept;  // of the last fuse
  // Levels of the last fuse that met a limit.
  std::size_t constrained() const noexcept;
  // How many directions all levels but the last have claimed; where this changes, the torque may step.
  std::size_t claimed() const noexcept;

  static constexpr double tolerance = HierarchicalQp::tolerance;  // by which limits may be missed, Nm and rad/s^2

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace robotskin::control
