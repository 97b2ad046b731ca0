#include "control/proxsuite_programme.hpp"

#include <proxsuite/proxqp/dense/dense.hpp>

namespace robotskin::control {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using Solver = proxsuite::proxqp::dense::QP<double>;
namespace proxqp = proxsuite::proxqp;

// ProxSuite's own pull to its last iterate, well below the pull to no torque of the programmes it is given.
constexpr double proximal = 1e-8;

}  // namespace

struct ProxsuiteProgramme::Workspace {
  Workspace(Eigen::Index variables, Eigen::Index limits, double tolerance)
      : size(variables), constraints(limits), solver(variables, 0, limits, false, proxqp::DenseBackend::PrimalLDLT) {
    solver.settings.eps_abs = tolerance;
    solver.settings.eps_rel = tolerance;
    solver.settings.max_iter = 200;
    solver.settings.default_rho = proximal;
    solver.settings.initial_guess = proxqp::InitialGuessStatus::NO_INITIAL_GUESS;
    const Matrix identity = Matrix::Identity(size, size), none = Matrix::Zero(constraints, size);
    const Vector zero = Vector::Zero(size), one = Vector::Ones(constraints);
    solver.init(identity, zero, proxsuite::nullopt, proxsuite::nullopt, none, -one, one, false);
    solver.solve();
  }

  Eigen::Index size, constraints;
  Solver solver;
};

ProxsuiteProgramme::ProxsuiteProgramme(std::size_t size, std::size_t constraints, double tolerance)
    : workspace_(std::make_unique<Workspace>(static_cast<Eigen::Index>(size), static_cast<Eigen::Index>(constraints),
                                             tolerance)) {}
ProxsuiteProgramme::~ProxsuiteProgramme() = default;
ProxsuiteProgramme::ProxsuiteProgramme(ProxsuiteProgramme&&) noexcept = default;
ProxsuiteProgramme& ProxsuiteProgramme::operator=(ProxsuiteProgramme&&) noexcept = default;

bool ProxsuiteProgramme::solve(const double* hessian, const double* gradient, const double* matrix, std::size_t stride,
                               std::size_t columns, const double* low, const double* high, double* x) noexcept {
  Solver& solver = workspace_->solver;
  const Eigen::Index size = workspace_->size, constraints = workspace_->constraints;
  solver.model.H = Eigen::Map<const Matrix>(hessian, size, size);
  solver.model.g = Eigen::Map<const Vector>(gradient, size);
  const auto used = static_cast<Eigen::Index>(columns);
  solver.model.C.setZero();
  solver.model.C.leftCols(used) = Eigen::Map<const Matrix, 0, Eigen::OuterStride<>>(
      matrix, constraints, used, Eigen::OuterStride<>(static_cast<Eigen::Index>(stride)));
  solver.model.l = Eigen::Map<const Vector>(low, constraints);
  solver.model.u = Eigen::Map<const Vector>(high, constraints);
  solver.update(proxsuite::nullopt, proxsuite::nullopt, proxsuite::nullopt, proxsuite::nullopt, proxsuite::nullopt,
                proxsuite::nullopt, proxsuite::nullopt, false);
  solver.work.refactorize = true;
  solver.solve();
  if (solver.results.info.status != proxqp::QPSolverOutput::PROXQP_SOLVED) return false;
  Eigen::Map<Vector>(x, size) = solver.results.x;
  return true;
}

}  // namespace robotskin::control
