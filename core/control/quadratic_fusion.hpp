// Fusion by a hierarchy of quadratic programmes: like the null-space hierarchy, and within the robot's limits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "control/null_space_fusion.hpp"
#include "control/task.hpp"
#include "model/robot_model.hpp"

namespace robotskin::control {

// acceleration: a joint may go only as fast as it can brake before its position limit, and no faster than its velocity
// limit, both stated for its acceleration. paper: eq. 27 as printed, bounds on the torque that shrink with the distance
// to the limits; at a limit it forbids even the torque that holds gravity, which is why it is a baseline.
enum class LimitForm : std::uint8_t { acceleration, paper };

struct QuadraticLimits {
  std::vector<double> lower, upper;  // (n) rad
  std::vector<double> velocity;      // (n) rad/s
  std::vector<double> torque;        // (n) Nm
  std::vector<double> braking;       // (n) rad/s^2 on which stopping before a position limit counts
  double margin_rad = 0.02;          // kept from the position limits
  double horizon_s = 0.02;           // in which a velocity beyond its bound is to come back
  LimitForm form = LimitForm::acceleration;
  double position_rate = 100;  // lambda of eq. 27, Nm/rad
  double velocity_rate = 100;  // mu of eq. 27, Nm s/rad

  // The limits of the robot's model; every joint brakes with `braking` rad/s^2.
  static QuadraticLimits of(const RobotModel& robot, double braking = 10);
};

// Rows of one programme with others: `acceleration` (rows) is what they are to have, as nearly as `weight` is great.
struct WeightedRows {
  std::span<const double> rows;          // (rows, n)
  std::span<const double> acceleration;  // (rows)
  double weight = 1;                     // of the squared error, 0 or more
};

// Level k: the torque tau = M a + bias nearest to giving its motions the acceleration that the level's own torque would
// give, J_k M^-1 tau = J_k M^-1 tau_k, without touching what higher levels have, and within the limits. Where no limit
// is met this is the minimum of a quadratic without constraints, which one Cholesky factor finds. From there an active
// set adds the limits that are met, beginning with those of the last tick; ProxSuite takes over a programme that it
// does not finish, and may then allocate memory, which nothing else does.
class QuadraticFusion {
 public:
  // Throws ControlError for limits that do not fit the robot.
  QuadraticFusion(std::size_t joint_count, std::size_t largest_rows, std::size_t levels, QuadraticLimits limits);
  ~QuadraticFusion();
  QuadraticFusion(QuadraticFusion&&) noexcept;
  QuadraticFusion& operator=(QuadraticFusion&&) noexcept;

  // fused (n) Nm, `unprojected` (n) included. `mass` (n, n) is the inertia that answers to torques and `bias` (n) the
  // torque of no acceleration. False if a size is wrong or there is no finite answer.
  [[nodiscard]] bool fuse(const TaskInput& input, std::span<const double> mass, std::span<const double> bias,
                          std::span<const double> unprojected, std::span<const FusionLevel> levels,
                          std::span<double> fused) noexcept;

  // All rows in one programme, without a hierarchy: min of the sum of weight |rows a - acceleration|^2 within the
  // limits. The other arguments are those of fuse, and so is what is returned.
  [[nodiscard]] bool fuse_weighted(const TaskInput& input, std::span<const double> mass, std::span<const double> bias,
                                   std::span<const double> unprojected, std::span<const WeightedRows> terms,
                                   std::span<double> fused) noexcept;

  // Of the last fuse: programmes that met a limit, and those among them that neither solver finished; such a level
  // contributes nothing.
  std::size_t constrained() const noexcept;
  std::size_t unsolved() const noexcept;
  // How many directions all levels but the last have claimed; where this changes, the torque may step.
  std::size_t claimed() const noexcept;

  static constexpr double tolerance = 1e-6;  // by which limits may be missed; of ProxSuite's optimality, too

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace robotskin::control
