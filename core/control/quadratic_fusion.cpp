// SPDX-License-Identifier: Apache-2.0
#include "control/quadratic_fusion.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "control/acceleration_bounds.hpp"
#include "control/braking_room.hpp"
#include "control/control_error.hpp"
#include "control/dense_kernels.hpp"

namespace robotskin::control {
namespace {

void check(const char* name, const std::vector<double>& values, std::size_t joints, bool positive) {
  if (values.size() != joints)
    throw ControlError(std::string("quadratic fusion: ") + name + " has " + std::to_string(values.size()) +
                       " values, the robot has " + std::to_string(joints) + " joints");
  for (const double& value : values)
    if (std::isnan(value) || (positive && !(value > 0)))
      throw ControlError(std::string("quadratic fusion: ") + name + " " + std::to_string(value) + " of joint " +
                         std::to_string(&value - values.data()) +
                         (positive ? " must be greater than 0; a torque limit is the effort limit of the robot's URDF"
                                   : " is not a number"));
}

constexpr double unlimited_nm = 1e6;

}  // namespace

QuadraticLimits QuadraticLimits::of(const RobotModel& robot, double braking) {
  QuadraticLimits limits;
  limits.lower.assign(robot.lower().begin(), robot.lower().end());
  limits.upper.assign(robot.upper().begin(), robot.upper().end());
  limits.velocity.assign(robot.velocity_limit().begin(), robot.velocity_limit().end());
  limits.torque.assign(robot.effort_limit().begin(), robot.effort_limit().end());
  // What moves the base of a standing robot is the floor, and not a motor.
  for (std::size_t i = 0; i < limits.torque.size(); ++i)
    if (!robot.actuated(i)) limits.torque[i] = unlimited_nm;
  limits.braking.assign(robot.joint_count(), braking);
  return limits;
}

// Torques stand in coordinates t = L^-1 tau with M = L L^T. Matrices are stored by columns.
struct QuadraticFusion::Workspace {
  Workspace(std::size_t joint_count, std::size_t largest_rows, std::size_t level_count, QuadraticLimits robot_limits)
      : limits(std::move(robot_limits)),
        n(joint_count),
        capacity(std::max(largest_rows, joint_count)),
        factor(n * n),
        matrix(2 * n * n),
        rows(capacity * n),
        wanted(capacity),
        levels(level_count),
        solver({.variables = n, .limits = 2 * n, .largest_rows = capacity, .levels = level_count}),
        braking_room(n) {
    for (auto* values : {&low, &high}) values->resize(2 * n);
    for (auto* values : {&chosen, &asked, &z, &torque, &at_rest, &last, &offset}) values->resize(n);
  }

  QuadraticLimits limits;
  std::size_t n, capacity;
  std::vector<double> factor;        // (n, n) L, zero above the diagonal
  std::vector<double> matrix;        // (2 n, n) acceleration and torque of t: L^-T, L
  std::vector<double> low, high;     // (2 n) their bounds, beside the feedforward torque
  std::vector<double> rows, wanted;  // (rows of all levels, n) J L^-T, and what these are to be
  std::vector<QpLevel> levels;
  HierarchicalQp solver;
  std::vector<double> chosen;   // (n) t
  std::vector<double> at_rest;  // (n) acceleration if the levels ask for no torque
  std::vector<double> asked, z, torque;
  std::vector<double> last, offset;     // (n) Nm, of the tick before; what fades
  double faded_s = 0;                   // since something began to
  std::size_t kept = 0;                 // levels that what fades may not change
  bool running = false, fades = false;  // there was a tick before; something fades
  BrakingRoom braking_room;
  FoundRoom room;     // of this tick
  StepBudget budget;  // of this tick
  FusionReport report;

  bool begin(const TaskInput& input, std::span<const double> mass, std::span<const double> bias,
             std::span<const double> feedforward);
  bool solve(std::size_t count, const TaskInput& input, std::span<const double> feedforward, std::span<double> fused);
  void set_matrix();
  void set_bounds(const TaskInput& input, std::span<const double> bias, std::span<const double> feedforward);
  void find_a_feasible_torque();
  double* take_rows(std::span<const double> own, double* place, std::size_t first, std::size_t count, double weight);
  void fade(double period_s);
};

void QuadraticFusion::Workspace::set_matrix() {
  std::ranges::fill(matrix, 0.0);
  for (std::size_t k = 0; k < n; ++k) {
    std::fill_n(&factor[k * n], k, 0.0);
    std::copy_n(&factor[k * n], n, &matrix[2 * n * k + n]);
    matrix[2 * n * k + k] = 1;
  }
  divide_by_transposed(factor.data(), n, n, matrix.data(), 2 * n, n);
}

// Rows 0 to n - 1 bound the acceleration, rows n to 2 n - 1 the torque beside the feedforward one.
void QuadraticFusion::Workspace::set_bounds(const TaskInput& input, std::span<const double> bias,
                                            std::span<const double> feedforward) {
  for (std::size_t i = 0; i < n; ++i) z[i] = feedforward[i] - bias[i];
  solve_lower(factor.data(), n, n, z.data());
  solve_lower_transposed(factor.data(), n, n, z.data());
  at_rest = z;
  for (std::size_t i = 0; i < n; ++i) {
    const double position = input.position[i], velocity = input.velocity[i];
    const double torque_bound = limits.torque[i];
    if (limits.form == LimitForm::paper) {
      low[i] = -1e20;
      high[i] = 1e20;
      const double up = std::min({torque_bound, limits.position_rate * (limits.upper[i] - position),
                                  limits.velocity_rate * (limits.velocity[i] - velocity)});
      const double down = std::max({-torque_bound, limits.position_rate * (limits.lower[i] - position),
                                    limits.velocity_rate * (-limits.velocity[i] - velocity)});
      low[n + i] = std::max(std::min(down, up) - feedforward[i], -1e20);
      high[n + i] = std::min(up - feedforward[i], 1e20);
      continue;
    }
    const AccelerationBounds bounds = acceleration_bounds(
        {limits.lower[i], limits.upper[i], limits.velocity[i], limits.braking[i], limits.margin_rad, limits.horizon_s},
        position, velocity);
    low[i] = std::max(bounds.low - z[i], -1e20);
    high[i] = std::min(bounds.high - z[i], 1e20);
    low[n + i] = std::max(-torque_bound - feedforward[i], -1e20);
    high[n + i] = std::min(torque_bound - feedforward[i], 1e20);
  }
}

// A point within all limits. Those of acceleration and torque may exclude each other, as where the motor is too weak to
// brake; then the former give way, as little as can be. The levels have the steps that this leaves.
void QuadraticFusion::Workspace::find_a_feasible_torque() {
  for (std::size_t i = 0; i < n; ++i) z[i] = std::clamp(0.0, low[i], high[i]);
  // t = L^T z, torque = L t
  transposed_product(factor.data(), n, n, n, z.data(), chosen.data());
  product(factor.data(), n, n, n, chosen.data(), torque.data());
  bool within = true;
  for (std::size_t i = 0; i < n; ++i) within = within && torque[i] >= low[n + i] && torque[i] <= high[n + i];
  room = within ? FoundRoom{} : braking_room.find(factor.data(), matrix.data(), low, high, chosen);
  budget.taken += room.steps;
}

// Rows `first` on of `count` at `place` are `weight` times these. Returns where the next level's rows begin.
double* QuadraticFusion::Workspace::take_rows(std::span<const double> own, double* place, std::size_t first,
                                              std::size_t count, double weight) {
  for (std::size_t i = 0; i < own.size() / n; ++i)
    for (std::size_t k = 0; k < n; ++k) place[first + i + k * count] = weight * own[k + i * n];
  return place + count * n;
}

bool QuadraticFusion::Workspace::solve(std::size_t count, const TaskInput& input, std::span<const double> feedforward,
                                       std::span<double> fused) {
  const std::size_t finished = report.finished;
  const bool before = report.fallback;
  if (!solver.solve({matrix.data(), low, high}, {levels.data(), count}, budget, chosen)) return false;
  report = {.steps = budget.taken,
            .room_steps = room.steps,
            .fallback = room.cut || solver.finished() < count,
            .by_clock = budget.by_clock,
            .widened = room.moved,
            .finished = room.cut ? 0 : solver.finished()};
  product(factor.data(), n, n, n, chosen.data(), torque.data());
  if (running && (before || report.fallback)) {
    kept = std::min({report.finished, before ? finished : count, fades ? kept : count});
    const double share = before && report.fallback ? std::max(1 - 1.5 * input.period_s / limits.fade_s, 0.0) : 1;
    for (std::size_t i = 0; i < n; ++i) offset[i] = share * (last[i] - torque[i]);
    faded_s = 0;
    fades = true;
  }
  if (fades) fade(input.period_s);
  last = torque;
  running = true;
  for (std::size_t i = 0; i < n; ++i) fused[i] = torque[i] + feedforward[i];
  return std::ranges::all_of(fused, [](double value) { return std::isfinite(value); });
}

// torque += what is left of the offset, without what would change the levels that are kept, and within the limits.
void QuadraticFusion::Workspace::fade(double period_s) {
  const double x = faded_s / limits.fade_s, left = 1 - x * x * (3 - 2 * x);
  for (std::size_t i = 0; i < n; ++i) z[i] = left * offset[i];
  solve_lower(factor.data(), n, n, z.data());
  solver.keep(kept, z);
  report.fade_limited = solver.move(z, chosen) < 1;
  product(factor.data(), n, n, n, chosen.data(), torque.data());
  faded_s += period_s;
  fades = faded_s < limits.fade_s;
}

QuadraticFusion::QuadraticFusion(std::size_t joint_count, std::size_t largest_rows, std::size_t levels,
                                 QuadraticLimits limits) {
  check("lower", limits.lower, joint_count, false);
  check("upper", limits.upper, joint_count, false);
  check("velocity", limits.velocity, joint_count, true);
  check("torque", limits.torque, joint_count, true);
  check("braking", limits.braking, joint_count, true);
  if (!(limits.margin_rad >= 0) || !std::isfinite(limits.margin_rad))
    throw ControlError("quadratic fusion: margin_rad " + std::to_string(limits.margin_rad) +
                       " must be finite and at least 0");
  for (const double value : {limits.horizon_s, limits.position_rate, limits.velocity_rate})
    if (!(value > 0) || !std::isfinite(value))
      throw ControlError("quadratic fusion: rate or horizon " + std::to_string(value) +
                         " must be finite and greater than 0");
  workspace_ = std::make_unique<Workspace>(joint_count, largest_rows, levels, std::move(limits));
}

QuadraticFusion::~QuadraticFusion() = default;
QuadraticFusion::QuadraticFusion(QuadraticFusion&&) noexcept = default;
QuadraticFusion& QuadraticFusion::operator=(QuadraticFusion&&) noexcept = default;

std::size_t QuadraticFusion::constrained() const noexcept {
  return workspace_->solver.constrained();
}
std::size_t QuadraticFusion::claimed() const noexcept {
  return workspace_->solver.claimed();
}
const FusionReport& QuadraticFusion::report() const noexcept {
  return workspace_->report;
}

void QuadraticFusion::set_steps(std::size_t steps) noexcept {
  workspace_->limits.steps = steps;
}

void QuadraticFusion::restart() noexcept {
  workspace_->running = workspace_->fades = false;
}

double QuadraticFusion::add_within_limits(std::span<const double> addition, std::span<double> fused) noexcept {
  Workspace& work = *workspace_;
  if (addition.size() != work.n || fused.size() != work.n) return 0;
  std::ranges::copy(addition, work.z.begin());
  solve_lower(work.factor.data(), work.n, work.n, work.z.data());
  const double share = work.solver.move(work.z, work.chosen);
  for (std::size_t i = 0; i < work.n; ++i) fused[i] += share * addition[i];
  return share;
}

bool QuadraticFusion::Workspace::begin(const TaskInput& input, std::span<const double> mass,
                                       std::span<const double> bias, std::span<const double> feedforward) {
  if (mass.size() != n * n || bias.size() != n || feedforward.size() != n || input.position.size() != n ||
      input.velocity.size() != n)
    return false;
  std::ranges::copy(mass, factor.begin());  // symmetric
  if (!factorise(factor.data(), n, n)) return false;
  budget = {.most = limits.steps, .deadline_ns = input.deadline_ns};
  set_matrix();
  set_bounds(input, bias, feedforward);
  find_a_feasible_torque();
  return true;
}

bool QuadraticFusion::fuse(const TaskInput& input, std::span<const double> mass, std::span<const double> bias,
                           std::span<const double> feedforward, std::span<const FusionLevel> levels,
                           std::span<double> fused) noexcept {
  Workspace& work = *workspace_;
  const std::size_t n = work.n;
  std::size_t total = 0;
  for (const FusionLevel& level : levels) total += level.rows.size() / n;
  if (fused.size() != n || levels.size() > work.levels.size() || total > work.capacity ||
      !work.begin(input, mass, bias, feedforward))
    return false;
  double *rows = work.rows.data(), *wanted = work.wanted.data();
  for (std::size_t index = 0; index < levels.size(); ++index) {
    const std::size_t count = levels[index].rows.size() / n;
    std::ranges::copy(levels[index].torque, work.asked.begin());
    solve_lower(work.factor.data(), n, n, work.asked.data());
    double* next = work.take_rows(levels[index].rows, rows, 0, count, 1);
    const std::span<const double> acceleration = levels[index].acceleration;
    if (!acceleration.empty()) {
      if (acceleration.size() != count) return false;
      for (std::size_t i = 0; i < count; ++i) {
        wanted[i] = acceleration[i];
        for (std::size_t k = 0; k < n; ++k) wanted[i] -= rows[i + k * count] * work.at_rest[k];
      }
    }
    divide_by_transposed(work.factor.data(), n, n, rows, count, count);
    if (acceleration.empty()) product(rows, count, count, n, work.asked.data(), wanted);
    work.levels[index] = {rows, {wanted, count}, {wanted, count}};
    rows = next;
    wanted += count;
  }
  return work.solve(levels.size(), input, feedforward, fused);
}

bool QuadraticFusion::fuse_weighted(const TaskInput& input, std::span<const double> mass, std::span<const double> bias,
                                    std::span<const double> feedforward, std::span<const WeightedRows> terms,
                                    std::span<double> fused) noexcept {
  Workspace& work = *workspace_;
  const std::size_t n = work.n;
  std::size_t count = 0;
  for (const WeightedRows& term : terms) count += term.acceleration.size();
  if (fused.size() != n || work.levels.empty() || count > work.capacity || !work.begin(input, mass, bias, feedforward))
    return false;
  std::size_t first = 0;
  double* wanted = work.wanted.data();
  for (const WeightedRows& term : terms) {
    if (term.rows.size() != n * term.acceleration.size() || !(term.weight >= 0)) return false;
    const double root = std::sqrt(term.weight);
    work.take_rows(term.rows, work.rows.data(), first, count, root);
    for (std::size_t i = 0; i < term.acceleration.size(); ++i, ++first) {
      wanted[first] = root * term.acceleration[i];
      for (std::size_t k = 0; k < n; ++k) wanted[first] -= work.rows[first + k * count] * work.at_rest[k];
    }
  }
  divide_by_transposed(work.factor.data(), n, n, work.rows.data(), count, count);
  work.levels[0] = {work.rows.data(), {wanted, count}, {wanted, count}};
  return work.solve(count > 0 ? 1 : 0, input, feedforward, fused);
}

}  // namespace robotskin::control
