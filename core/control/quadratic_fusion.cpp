#include "control/quadratic_fusion.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "control/active_set.hpp"
#include "control/control_error.hpp"
#include "control/dense_kernels.hpp"
#include "control/proxsuite_programme.hpp"

namespace robotskin::control {
namespace {

// Weight of staying near no torque at all where a level leaves a choice, against its own squared error.
constexpr double least_effort = 1e-6;
// A row whose part outside of what is claimed already is shorter than this claims nothing.
constexpr double least_row = 1e-3;

void check(const char* name, const std::vector<double>& values, std::size_t joints, bool positive) {
  if (values.size() != joints)
    throw ControlError(std::string("quadratic fusion: ") + name + " has " + std::to_string(values.size()) +
                       " values, the robot has " + std::to_string(joints) + " joints");
  for (const double value : values)
    if (std::isnan(value) || (positive && !(value > 0)))
      throw ControlError(std::string("quadratic fusion: ") + name + " " + std::to_string(value) +
                         (positive ? " must be greater than 0" : " is not a number"));
}

}  // namespace

QuadraticLimits QuadraticLimits::of(const RobotModel& robot, double braking) {
  QuadraticLimits limits;
  limits.lower.assign(robot.lower().begin(), robot.lower().end());
  limits.upper.assign(robot.upper().begin(), robot.upper().end());
  limits.velocity.assign(robot.velocity_limit().begin(), robot.velocity_limit().end());
  limits.torque.assign(robot.effort_limit().begin(), robot.effort_limit().end());
  limits.braking.assign(robot.joint_count(), braking);
  return limits;
}

// Torques stand in coordinates t = L^-1 tau with M = L L^T. Matrices are stored by columns.
struct QuadraticFusion::Workspace {
  Workspace(std::size_t joint_count, std::size_t largest_rows, std::size_t level_count, QuadraticLimits robot_limits)
      : limits(std::move(robot_limits)),
        n(joint_count),
        capacity(std::max(largest_rows, joint_count)),
        levels(level_count),
        factor(n * n),
        turned(3 * n * n),
        rows(capacity * n),
        reduced(capacity * n),
        hessian(n * n),
        cholesky(n * n),
        side(levels * 2 * n),
        active_set(n, 2 * n),
        programme(n, 2 * n, tolerance) {
    for (auto* values : {&low, &high, &value, &room_low, &room_high}) values->resize(2 * n);
    for (auto* values : {&chosen, &asked, &gradient, &z, &torque, &at_rest, &reflector}) values->resize(n);
    error.resize(capacity);
    image.resize(std::max(3 * n, capacity));
  }

  QuadraticLimits limits;
  std::size_t n, capacity, levels;
  std::vector<double> factor;  // (n, n) L, zero above the diagonal
  // (3 n, n): acceleration and torque of each column of the basis, and the basis itself, orthonormal, first what higher
  // levels have claimed, then what is left.
  std::vector<double> turned;
  std::vector<double> rows, reduced;        // (capacity, n) J L^-T, and that in the coordinates of what is left
  std::vector<double> hessian, cholesky;    // (left, left) with stride n
  std::vector<double> low, high, value;     // (2 n) bounds of acceleration and torque, and what these are
  std::vector<double> room_low, room_high;  // (2 n) from the levels so far to the bounds
  std::vector<double> chosen;               // (n) t of the levels so far
  std::vector<double> at_rest;              // (n) acceleration if the levels ask for no torque
  std::vector<double> asked, gradient, z, torque, reflector, error, image;
  std::vector<std::int8_t> side;  // (levels, 2 n) the bounds that each level met in its last programme
  ActiveSet active_set;
  ProxsuiteProgramme programme;
  std::size_t claimed = 0, constrained = 0, unsolved = 0;

  const double* free() const noexcept { return &turned[3 * n * claimed]; }
  const double* free_basis() const noexcept { return free() + 2 * n; }

  bool begin(const TaskInput& input, std::span<const double> mass, std::span<const double> bias,
             std::span<const double> unprojected);
  bool finish(std::span<const double> unprojected, std::span<double> fused);
  void set_frame();
  void set_bounds(const TaskInput& input, std::span<const double> bias, std::span<const double> unprojected);
  void widen_to_a_feasible_torque();
  bool solve_level(const FusionLevel& level, std::size_t index);
  bool solve_weighted(std::span<const WeightedRows> terms);
  void take_rows(std::span<const double> own, std::size_t first, std::size_t count, double weight);
  bool solve_rows(std::size_t count, std::size_t index);
  bool solve_within_bounds(std::size_t left, std::int8_t* level_side);
  bool solve_by_proxsuite(std::size_t left);
  void claim(std::size_t count);
};

void QuadraticFusion::Workspace::set_frame() {
  claimed = constrained = unsolved = 0;
  std::ranges::fill(turned, 0.0);
  for (std::size_t k = 0; k < n; ++k) {
    std::fill_n(&factor[k * n], k, 0.0);
    std::copy_n(&factor[k * n], n, &turned[3 * n * k + n]);
    turned[3 * n * k + k] = turned[3 * n * k + 2 * n + k] = 1;
  }
  divide_by_transposed(factor.data(), n, n, turned.data(), 3 * n, n);
}

// Rows 0 to n - 1 bound the acceleration, rows n to 2 n - 1 the torque beside the unprojected one.
void QuadraticFusion::Workspace::set_bounds(const TaskInput& input, std::span<const double> bias,
                                            std::span<const double> unprojected) {
  for (std::size_t i = 0; i < n; ++i) z[i] = unprojected[i] - bias[i];
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
      low[n + i] = std::max(std::min(down, up) - unprojected[i], -1e20);
      high[n + i] = std::min(up - unprojected[i], 1e20);
      continue;
    }
    const double room_up = std::max(limits.upper[i] - limits.margin_rad - position, 0.0);
    const double room_down = std::max(position - limits.lower[i] - limits.margin_rad, 0.0);
    const double fastest_up = std::min(limits.velocity[i], std::sqrt(2 * limits.braking[i] * room_up));
    const double fastest_down = std::min(limits.velocity[i], std::sqrt(2 * limits.braking[i] * room_down));
    low[i] = std::max((-fastest_down - velocity) / limits.horizon_s - z[i], -1e20);
    high[i] = std::min((fastest_up - velocity) / limits.horizon_s - z[i], 1e20);
    low[n + i] = std::max(-torque_bound - unprojected[i], -1e20);
    high[n + i] = std::min(torque_bound - unprojected[i], 1e20);
  }
}

// Limits of acceleration and torque may exclude each other, as where the motor is too weak to brake. Then the former
// give way, so far that the torque nearest to the wanted deceleration is allowed.
void QuadraticFusion::Workspace::widen_to_a_feasible_torque() {
  for (std::size_t i = 0; i < n; ++i) z[i] = std::clamp(0.0, low[i], high[i]);
  // t = L^T z, torque = L t
  transposed_product(factor.data(), n, n, n, z.data(), chosen.data());
  product(factor.data(), n, n, n, chosen.data(), torque.data());
  bool cut = false;
  for (std::size_t i = 0; i < n; ++i) {
    const double allowed = std::clamp(torque[i], low[n + i], high[n + i]);
    cut = cut || allowed != torque[i];
    torque[i] = allowed;
  }
  if (!cut) return;
  solve_lower(factor.data(), n, n, torque.data());
  chosen = torque;
  z = chosen;
  solve_lower_transposed(factor.data(), n, n, z.data());
  for (std::size_t i = 0; i < n; ++i) {
    low[i] = std::min(low[i], z[i]);
    high[i] = std::max(high[i], z[i]);
  }
}

bool QuadraticFusion::Workspace::solve_level(const FusionLevel& level, std::size_t index) {
  const std::size_t count = level.rows.size() / n;
  if (count > capacity) return false;
  if (count == 0 || claimed == n) return true;
  std::ranges::copy(level.torque, asked.begin());
  solve_lower(factor.data(), n, n, asked.data());
  for (std::size_t i = 0; i < n; ++i) asked[i] -= chosen[i];
  take_rows(level.rows, 0, count, 1);
  divide_by_transposed(factor.data(), n, n, rows.data(), count, count);
  product(rows.data(), count, count, n, asked.data(), error.data());
  if (!solve_rows(count, index)) return false;
  if (index + 1 < levels) claim(count);
  return true;
}

bool QuadraticFusion::Workspace::solve_weighted(std::span<const WeightedRows> terms) {
  std::size_t count = 0;
  for (const WeightedRows& term : terms) count += term.acceleration.size();
  if (count > capacity) return false;
  if (count == 0) return true;
  std::size_t first = 0;
  for (const WeightedRows& term : terms) {
    if (term.rows.size() != n * term.acceleration.size() || !(term.weight >= 0)) return false;
    const double root = std::sqrt(term.weight);
    take_rows(term.rows, first, count, root);
    for (const double wanted : term.acceleration) error[first++] = root * wanted;
  }
  product(rows.data(), count, count, n, at_rest.data(), image.data());
  for (std::size_t i = 0; i < count; ++i) error[i] -= image[i];
  divide_by_transposed(factor.data(), n, n, rows.data(), count, count);
  product(rows.data(), count, count, n, chosen.data(), image.data());
  for (std::size_t i = 0; i < count; ++i) error[i] -= image[i];
  return solve_rows(count, 0);
}

// Rows `first` on of `count` are `weight` times these.
void QuadraticFusion::Workspace::take_rows(std::span<const double> own, std::size_t first, std::size_t count,
                                           double weight) {
  for (std::size_t i = 0; i < own.size() / n; ++i)
    for (std::size_t k = 0; k < n; ++k) rows[first + i + k * count] = weight * own[k + i * n];
}

// With rows J L^-T and their error: the best torque within the bounds beside what is claimed.
bool QuadraticFusion::Workspace::solve_rows(std::size_t count, std::size_t index) {
  const std::size_t left = n - claimed;
  for (std::size_t k = 0; k < left; ++k)
    product(rows.data(), count, count, n, free_basis() + 3 * n * k, &reduced[k * count]);

  // min |reduced z - error|^2 + least_effort |chosen + basis z|^2
  transposed_product(reduced.data(), count, count, left, error.data(), z.data());
  transposed_product(free_basis(), 3 * n, n, left, chosen.data(), gradient.data());
  for (std::size_t k = 0; k < left; ++k) {
    gradient[k] = least_effort * gradient[k] - z[k];
    z[k] = -gradient[k];
    double* column = &hessian[k + k * n];
    transposed_product(&reduced[k * count], count, count, left - k, &reduced[k * count], column);
    *column += least_effort;
    std::copy_n(column, left - k, &cholesky[k + k * n]);
  }
  if (!factorise(cholesky.data(), n, left)) return false;
  solve_lower(cholesky.data(), n, left, z.data());
  solve_lower_transposed(cholesky.data(), n, left, z.data());

  if (!solve_within_bounds(left, &side[index * 2 * n])) std::ranges::fill(z, 0.0);
  product(free_basis(), 3 * n, n, left, z.data(), torque.data());
  for (std::size_t i = 0; i < n; ++i) {
    chosen[i] += torque[i];
    if (!std::isfinite(chosen[i])) return false;
  }
  return true;
}

// z: in, the minimum without bounds; out, the one within them. False if no solver finished.
bool QuadraticFusion::Workspace::solve_within_bounds(std::size_t left, std::int8_t* level_side) {
  std::ranges::copy(chosen, value.begin());
  solve_lower_transposed(factor.data(), n, n, value.data());
  product(factor.data(), n, n, n, chosen.data(), &value[n]);
  product(free(), 3 * n, 2 * n, left, z.data(), image.data());
  bool inside = true;
  for (std::size_t i = 0; i < 2 * n; ++i) {
    // What higher levels have stays allowed, whatever rounding makes of it.
    room_low[i] = std::min(low[i] - value[i], 0.0);
    room_high[i] = std::max(high[i] - value[i], 0.0);
    inside = inside && image[i] >= room_low[i] - tolerance && image[i] <= room_high[i] + tolerance;
  }
  if (inside) {
    std::fill_n(level_side, 2 * n, std::int8_t{0});
    return true;
  }
  ++constrained;
  const ActiveSet::Problem problem{
      left, 2 * n, cholesky.data(), n, free(), 3 * n, room_low.data(), room_high.data(), 0.1 * tolerance};
  if (active_set.solve(problem, z.data(), level_side) || solve_by_proxsuite(left)) return true;
  ++unsolved;
  return false;
}

// For a programme so ill-conditioned that the active set does not come to an end.
bool QuadraticFusion::Workspace::solve_by_proxsuite(std::size_t left) {
  // The solver is of n variables; those that are claimed stand in no constraint and are best zero.
  for (std::size_t k = 0; k < n; ++k) {
    if (k >= left) {
      std::fill_n(&hessian[k * n], n, 0.0);
      hessian[k + k * n] = 1;
      gradient[k] = 0;
    }
    for (std::size_t i = 0; i < k; ++i) hessian[i + k * n] = k < left ? hessian[k + i * n] : 0;
    for (std::size_t i = left; i < n && k < left; ++i) hessian[i + k * n] = 0;
  }
  return programme.solve(hessian.data(), gradient.data(), free(), 3 * n, left, room_low.data(), room_high.data(),
                         z.data());
}

// Turns the basis of what is left so that its first columns are the rows, and counts these as claimed.
void QuadraticFusion::Workspace::claim(std::size_t count) {
  const std::size_t before = claimed;
  for (std::size_t i = 0; i < count && claimed < n; ++i) {
    const std::size_t left = n - claimed;
    double* own = &reduced[(claimed - before) * count];
    double square = 0;
    for (std::size_t k = 0; k < left; ++k) {
      reflector[k] = own[i + k * count];
      square += reflector[k] * reflector[k];
    }
    const double length = std::sqrt(square);
    if (length < least_row) continue;
    const double first = reflector[0];
    reflector[0] += first >= 0 ? length : -length;
    const double factor_of_two = 1 / (square + std::abs(first) * length);
    double* basis = &turned[3 * n * claimed];
    const auto reflect = [&](double* matrix, std::size_t stride) {
      product(matrix, stride, stride, left, reflector.data(), image.data());
      for (std::size_t k = 0; k < stride; ++k) image[k] *= factor_of_two;
      subtract_outer(matrix, stride, stride, left, image.data(), reflector.data());
    };
    reflect(basis, 3 * n);
    reflect(own, count);
    ++claimed;
  }
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
  return workspace_->constrained;
}
std::size_t QuadraticFusion::unsolved() const noexcept {
  return workspace_->unsolved;
}
std::size_t QuadraticFusion::claimed() const noexcept {
  return workspace_->claimed;
}

bool QuadraticFusion::Workspace::begin(const TaskInput& input, std::span<const double> mass,
                                       std::span<const double> bias, std::span<const double> unprojected) {
  if (mass.size() != n * n || bias.size() != n || unprojected.size() != n || input.position.size() != n ||
      input.velocity.size() != n)
    return false;
  std::ranges::copy(mass, factor.begin());  // symmetric
  if (!factorise(factor.data(), n, n)) return false;
  set_frame();
  set_bounds(input, bias, unprojected);
  widen_to_a_feasible_torque();
  return true;
}

bool QuadraticFusion::Workspace::finish(std::span<const double> unprojected, std::span<double> fused) {
  product(factor.data(), n, n, n, chosen.data(), fused.data());
  for (std::size_t i = 0; i < n; ++i) fused[i] += unprojected[i];
  return std::ranges::all_of(fused, [](double value) { return std::isfinite(value); });
}

bool QuadraticFusion::fuse(const TaskInput& input, std::span<const double> mass, std::span<const double> bias,
                           std::span<const double> unprojected, std::span<const FusionLevel> levels,
                           std::span<double> fused) noexcept {
  Workspace& work = *workspace_;
  if (fused.size() != work.n || levels.size() > work.levels || !work.begin(input, mass, bias, unprojected))
    return false;
  for (std::size_t level = 0; level < levels.size(); ++level)
    if (!work.solve_level(levels[level], level)) return false;
  return work.finish(unprojected, fused);
}

bool QuadraticFusion::fuse_weighted(const TaskInput& input, std::span<const double> mass, std::span<const double> bias,
                                    std::span<const double> unprojected, std::span<const WeightedRows> terms,
                                    std::span<double> fused) noexcept {
  Workspace& work = *workspace_;
  return fused.size() == work.n && work.levels > 0 && work.begin(input, mass, bias, unprojected) &&
         work.solve_weighted(terms) && work.finish(unprojected, fused);
}

}  // namespace robotskin::control
