#include "control/quadratic_fusion.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <proxsuite/proxqp/dense/dense.hpp>
#include <string>
#include <utility>

#include "control/active_set.hpp"
#include "control/control_error.hpp"

namespace robotskin::control {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using Programme = proxsuite::proxqp::dense::QP<double>;
using ConstVector = Eigen::Map<const Vector>;

// Weight of staying near no torque at all where a level leaves a choice, against its own squared error.
constexpr double least_effort = 1e-6;
// ProxSuite's own pull to its last iterate, well below the pull to no torque, which then decides.
constexpr double proximal = 1e-8;
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

struct QuadraticFusion::Workspace {
  Workspace(std::size_t joint_count, std::size_t largest_rows, std::size_t levels, QuadraticLimits robot_limits)
      : limits(std::move(robot_limits)),
        n(static_cast<Eigen::Index>(joint_count)),
        capacity(static_cast<Eigen::Index>(std::max(largest_rows, joint_count))),
        factor(n, n),
        inverse(n, n),
        basis(n, n),
        rows(n, capacity),
        reduced(n, capacity),
        constraint(2 * n, n),
        map(2 * n, n),
        hessian(n, n),
        cholesky(n, n),
        low(2 * n),
        high(2 * n),
        value(2 * n),
        chosen(n),
        asked(n),
        gradient(n),
        z(n),
        torque(n),
        rest(n),
        household(n),
        error(capacity),
        active_set(joint_count, 2 * joint_count) {
    programmes.reserve(levels);
    for (std::size_t level = 0; level < levels; ++level) {
      Programme& programme = programmes.emplace_back(n, 0, 2 * n, false, proxsuite::proxqp::DenseBackend::PrimalLDLT);
      programme.settings.eps_abs = tolerance;
      programme.settings.eps_rel = tolerance;
      programme.settings.max_iter = 200;
      programme.settings.default_rho = proximal;
      programme.settings.initial_guess = proxsuite::proxqp::InitialGuessStatus::WARM_START_WITH_PREVIOUS_RESULT;
      const Matrix identity = Matrix::Identity(n, n), none = Matrix::Zero(2 * n, n);
      const Vector zero = Vector::Zero(n), one = Vector::Ones(2 * n);
      programme.init(identity, zero, proxsuite::nullopt, proxsuite::nullopt, none, -one, one, false);
      programme.solve();
    }
  }

  QuadraticLimits limits;
  Eigen::Index n, capacity;
  std::vector<Programme> programmes;  // one a level, so that each starts from its own last answer
  Matrix factor;                      // L of M = L L^T
  Matrix inverse;                     // L^-T: acceleration of a torque in coordinates t = L^-1 tau
  Matrix basis;                       // (n, n) orthonormal: first what higher levels have claimed, then what is left
  Matrix rows, reduced;               // (n, s) columns L^-1 J^T, and those in the coordinates of what is left
  Matrix constraint, map;             // (2 n, n) from t to acceleration and torque; the same from z
  Matrix hessian, cholesky;
  Vector low, high, value;  // (2 n) bounds of constraint t, and constraint t
  Vector chosen;            // (n) t of the levels so far
  Vector asked, gradient, z, torque, rest, household, error;
  ActiveSet active_set;
  Eigen::Index claimed = 0;
  std::size_t constrained = 0, unsolved = 0;

  void set_bounds(const TaskInput& input, ConstVector bias, ConstVector unprojected);
  void widen_to_a_feasible_torque();
  bool solve_level(const FusionLevel& level, std::size_t index);
  bool solve_by_proxsuite(Programme& programme);
  void claim(Eigen::Index count);
  bool inside() const noexcept {
    const Eigen::Index count = 2 * n;
    for (Eigen::Index i = 0; i < count; ++i)
      if (value[i] < low[i] - tolerance || value[i] > high[i] + tolerance) return false;
    return true;
  }
};

// Rows 0 to n - 1 bound the acceleration, rows n to 2 n - 1 the torque beside the unprojected one.
void QuadraticFusion::Workspace::set_bounds(const TaskInput& input, ConstVector bias, ConstVector unprojected) {
  rest = unprojected - bias;  // the torque that acts if the levels ask for none
  factor.triangularView<Eigen::Lower>().solveInPlace(rest);
  z.noalias() = inverse * rest;  // its acceleration
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto joint = static_cast<std::size_t>(i);
    const double position = input.position[joint], velocity = input.velocity[joint];
    const double torque_bound = limits.torque[joint];
    if (limits.form == LimitForm::paper) {
      low[i] = -1e20;
      high[i] = 1e20;
      const double up = std::min({torque_bound, limits.position_rate * (limits.upper[joint] - position),
                                  limits.velocity_rate * (limits.velocity[joint] - velocity)});
      const double down = std::max({-torque_bound, limits.position_rate * (limits.lower[joint] - position),
                                    limits.velocity_rate * (-limits.velocity[joint] - velocity)});
      low[n + i] = std::max(std::min(down, up) - unprojected[i], -1e20);
      high[n + i] = std::min(up - unprojected[i], 1e20);
      continue;
    }
    const double room_up = std::max(limits.upper[joint] - limits.margin_rad - position, 0.0);
    const double room_down = std::max(position - limits.lower[joint] - limits.margin_rad, 0.0);
    const double fastest_up = std::min(limits.velocity[joint], std::sqrt(2 * limits.braking[joint] * room_up));
    const double fastest_down = std::min(limits.velocity[joint], std::sqrt(2 * limits.braking[joint] * room_down));
    low[i] = std::max((-fastest_down - velocity) / limits.horizon_s - z[i], -1e20);
    high[i] = std::min((fastest_up - velocity) / limits.horizon_s - z[i], 1e20);
    low[n + i] = std::max(-torque_bound - unprojected[i], -1e20);
    high[n + i] = std::min(torque_bound - unprojected[i], 1e20);
  }
}

// Limits of acceleration and torque may exclude each other, as where the motor is too weak to brake. Then the former
// give way, so far that the torque nearest to the wanted deceleration is allowed.
void QuadraticFusion::Workspace::widen_to_a_feasible_torque() {
  for (Eigen::Index i = 0; i < n; ++i) z[i] = std::clamp(0.0, low[i], high[i]);
  // torque = L L^T z, t = L^T z
  chosen.noalias() = factor.transpose().triangularView<Eigen::Upper>() * z;
  torque.noalias() = factor.triangularView<Eigen::Lower>() * chosen;
  bool cut = false;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double allowed = std::clamp(torque[i], low[n + i], high[n + i]);
    cut = cut || allowed != torque[i];
    torque[i] = allowed;
  }
  if (!cut) return;
  factor.triangularView<Eigen::Lower>().solveInPlace(torque);
  chosen = torque;
  z.noalias() = inverse * chosen;
  for (Eigen::Index i = 0; i < n; ++i) {
    low[i] = std::min(low[i], z[i]);
    high[i] = std::max(high[i], z[i]);
  }
}

bool QuadraticFusion::Workspace::solve_level(const FusionLevel& level, std::size_t index) {
  const auto count = static_cast<Eigen::Index>(level.rows.size()) / n;
  const Eigen::Index left = n - claimed;
  if (count > capacity) return false;
  if (count == 0 || left == 0) return true;
  asked = ConstVector(level.torque.data(), n);
  factor.triangularView<Eigen::Lower>().solveInPlace(asked);
  for (Eigen::Index i = 0; i < count; ++i) rows.col(i) = ConstVector(level.rows.data() + i * n, n);
  factor.triangularView<Eigen::Lower>().solveInPlace(rows.leftCols(count));

  const auto free = basis.rightCols(left);
  reduced.topLeftCorner(left, count).noalias() = free.transpose() * rows.leftCols(count);
  asked -= chosen;
  error.head(count).noalias() = rows.leftCols(count).transpose() * asked;
  // min |reduced^T z - error|^2 + least_effort |chosen + free z|^2
  hessian.setIdentity();
  auto own = hessian.topLeftCorner(left, left);
  own.noalias() = reduced.topLeftCorner(left, count) * reduced.topLeftCorner(left, count).transpose();
  own.diagonal().array() += least_effort;
  gradient.setZero();
  gradient.head(left).noalias() = -reduced.topLeftCorner(left, count) * error.head(count);
  gradient.head(left).noalias() += least_effort * (free.transpose() * chosen);

  cholesky.topLeftCorner(left, left) = own;
  Eigen::Ref<Matrix> block = cholesky.topLeftCorner(left, left);
  const Eigen::LLT<Eigen::Ref<Matrix>> solver(block);
  if (solver.info() != Eigen::Success) return false;
  z.setZero();
  z.head(left) = -gradient.head(left);
  auto answer = z.head(left);
  solver.solveInPlace(answer);
  torque = chosen;
  torque.noalias() += free * z.head(left);
  value.noalias() = constraint * torque;
  if (!inside()) {
    ++constrained;
    map.setZero();
    map.leftCols(left).noalias() = constraint * free;
    value.noalias() = constraint * chosen;
    low -= value;
    high -= value;
    const bool found = active_set.solve(
        {static_cast<std::size_t>(left), static_cast<std::size_t>(2 * n), cholesky.data(), static_cast<std::size_t>(n),
         map.data(), static_cast<std::size_t>(2 * n), low.data(), high.data(), 0.1 * tolerance},
        z.data());
    torque = chosen;
    if (found) {
      torque.noalias() += free * z.head(left);
    } else if (solve_by_proxsuite(programmes[index])) {
      torque.noalias() += free * programmes[index].results.x.head(left);
    } else {
      ++unsolved;
    }
    low += value;
    high += value;
  }
  if (!torque.allFinite()) return false;
  chosen = torque;
  claim(count);
  return true;
}

// For the few programmes with so many limits met at once that the active set does not come to an end.
bool QuadraticFusion::Workspace::solve_by_proxsuite(Programme& programme) {
  programme.model.H = hessian;
  programme.model.g = gradient;
  programme.model.C = map;
  programme.model.l = low;
  programme.model.u = high;
  programme.update(proxsuite::nullopt, proxsuite::nullopt, proxsuite::nullopt, proxsuite::nullopt, proxsuite::nullopt,
                   proxsuite::nullopt, proxsuite::nullopt, false);
  programme.work.refactorize = true;
  programme.solve();
  return programme.results.info.status == proxsuite::proxqp::QPSolverOutput::PROXQP_SOLVED;
}

// Turns the basis of what is left so that its first columns are the rows, and counts these as claimed.
void QuadraticFusion::Workspace::claim(Eigen::Index count) {
  for (Eigen::Index i = 0; i < count && claimed < n; ++i) {
    const Eigen::Index left = n - claimed;
    auto part = household.head(left);
    part.noalias() = basis.rightCols(left).transpose() * rows.col(i);
    const double length = part.norm();
    if (length < least_row) continue;
    part[0] += part[0] >= 0 ? length : -length;
    const double square = part.squaredNorm();
    torque.noalias() = basis.rightCols(left) * part;
    basis.rightCols(left).noalias() -= (2 / square) * torque * part.transpose();
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
  return static_cast<std::size_t>(workspace_->claimed);
}

bool QuadraticFusion::fuse(const TaskInput& input, std::span<const double> mass, std::span<const double> bias,
                           std::span<const double> unprojected, std::span<const FusionLevel> levels,
                           std::span<double> fused) noexcept {
  Workspace& work = *workspace_;
  const auto joints = static_cast<std::size_t>(work.n);
  if (mass.size() != joints * joints || bias.size() != joints || unprojected.size() != joints ||
      fused.size() != joints || input.position.size() != joints || input.velocity.size() != joints ||
      levels.size() > work.programmes.size())
    return false;
  work.factor = Eigen::Map<const Matrix>(mass.data(), work.n, work.n);  // symmetric
  const Eigen::LLT<Eigen::Ref<Matrix>> cholesky(work.factor);
  if (cholesky.info() != Eigen::Success) return false;
  work.factor.triangularView<Eigen::StrictlyUpper>().setZero();
  work.inverse.setIdentity();
  work.factor.transpose().triangularView<Eigen::Upper>().solveInPlace(work.inverse);
  work.constraint.topRows(work.n) = work.inverse;
  work.constraint.bottomRows(work.n) = work.factor;
  work.basis.setIdentity();
  work.claimed = 0;
  work.constrained = work.unsolved = 0;

  const ConstVector bias_vector(bias.data(), work.n), unprojected_vector(unprojected.data(), work.n);
  work.set_bounds(input, bias_vector, unprojected_vector);
  work.widen_to_a_feasible_torque();
  for (std::size_t level = 0; level < levels.size(); ++level)
    if (!work.solve_level(levels[level], level)) return false;
  work.torque.noalias() = work.factor.triangularView<Eigen::Lower>() * work.chosen;
  for (std::size_t i = 0; i < joints; ++i) fused[i] = work.torque[static_cast<Eigen::Index>(i)] + unprojected[i];
  return work.torque.allFinite();
}

}  // namespace robotskin::control
