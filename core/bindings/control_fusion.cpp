// SPDX-License-Identifier: Apache-2.0
// Binds the fusions, the stack and the solver of hierarchies.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>

#include "bindings/arrays.hpp"
#include "bindings/bindings.hpp"
#include "bindings/task_input.hpp"
#include "control/hierarchical_qp.hpp"
#include "control/task_stack.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::bindings {
namespace {

using control::Task;
using control::TaskInput;

using Columns = nb::ndarray<const double, nb::ndim<2>, nb::f_contig, nb::device::cpu>;

void bind_solver(nb::module_& module) {
  using control::HierarchicalQp;
  using control::StepBudget;
  // The answer and how it was found, all of one solve.
  struct Answer {
    std::vector<double> x;
    std::vector<std::vector<double>> missed;
    std::size_t steps, finished, constrained;
  };
  nb::class_<Answer>(module, "QpAnswer", "What HierarchicalQp.solve has found.")
      .def_prop_ro(
          "x", [](const Answer& self) { return copy_of(std::span<const double>(self.x)); }, nb::rv_policy::move, "(n)")
      .def(
          "missed",
          [](const Answer& self, std::size_t level) { return copy_of(std::span<const double>(self.missed.at(level))); },
          "level"_a, nb::rv_policy::move, "(k) rows x less what the level wanted, 0 within a range.")
      .def_ro("steps", &Answer::steps, "limits added and dropped")
      .def_ro("finished", &Answer::finished, "levels that are exact, from the highest on")
      .def_ro("constrained", &Answer::constrained, "levels that met a limit");
  nb::class_<HierarchicalQp>(module, "HierarchicalQp",
                             "Least squares in a strict hierarchy, within limits: each level does its best in what\n"
                             "higher ones have left. One object solves one kind of problem again and again, each time\n"
                             "beginning with the limits that were met the last time.")
      .def(
          "__init__",
          [](HierarchicalQp* self, std::size_t variables, std::size_t limits, std::size_t largest_rows,
             std::size_t levels,
             std::size_t ranges) { new (self) HierarchicalQp({variables, limits, largest_rows, levels, ranges}); },
          "variables"_a, "limits"_a, "largest_rows"_a, "levels"_a, "ranges"_a = 0,
          "Room for n variables, m limits, so many rows a level and levels, and `ranges` rows that are no equations.")
      .def(
          "solve",
          [](HierarchicalQp& self, Columns matrix, Doubles low, Doubles high,
             const std::vector<std::tuple<Columns, Doubles, Doubles>>& levels, std::optional<Doubles> start,
             std::size_t steps) {
            const std::size_t n = matrix.shape(1);
            require(low.shape(0) == matrix.shape(0) && high.shape(0) == matrix.shape(0),
                    "the matrix of limits (m, n) must have a row for each of low and high (m)");
            require(!start || start->shape(0) == n, "start (n) must have an entry for each column of the matrix");
            Answer answer{.x = std::vector<double>(n), .missed = {}, .steps = 0, .finished = 0, .constrained = 0};
            if (start) std::ranges::copy(span_of(*start), answer.x.begin());
            std::vector<control::QpLevel> all;
            for (const auto& [rows, least, most] : levels) {
              require(rows.shape(1) == n && least.shape(0) == rows.shape(0) && most.shape(0) == rows.shape(0),
                      "a level is rows (k, n), low (k), high (k)");
              all.push_back({rows.data(), span_of(least), span_of(most)});
            }
            StepBudget budget{.most = steps};
            require(self.solve({matrix.data(), span_of(low), span_of(high)}, all, budget, answer.x),
                    "more variables, limits, rows, levels or ranges than there is room for, or numbers not finite");
            for (std::size_t i = 0; i < all.size(); ++i) {
              const std::span<const double> missed = self.missed(i);
              answer.missed.emplace_back(missed.begin(), missed.end());
            }
            answer.steps = budget.taken;
            answer.finished = self.finished();
            answer.constrained = self.constrained();
            return answer;
          },
          "matrix"_a, "low"_a, "high"_a, "levels"_a, "start"_a = nb::none(), "steps"_a = 400,
          "The x (n) with low <= matrix x <= high, (m, n) and (m), that is best for the levels, the highest first:\n"
          "(rows (k, n), low (k), high (k)), where equal bounds make an equation. start (n) lies within the limits; "
          "it\n"
          "is 0 if it is not given. Where `steps` end, x still keeps all limits and the levels that are finished.")
      .def("restart", &HierarchicalQp::restart, "Forgets which limits were met.");
}

}  // namespace

void bind_control_fusion(nb::module_& module) {
  using control::Damping;
  using control::Fusion;
  using control::FusionReport;
  using control::Inverse;
  using control::LimitForm;
  using control::NullSpaceFusion;
  using control::QuadraticFusion;
  using control::QuadraticLimits;
  using control::StackEntry;
  using control::TaskStack;
  bind_solver(module);
  nb::enum_<Fusion>(module, "Fusion", "How the tasks of a stack become one torque.")
      .value("weighted_sum", Fusion::weighted_sum, "[Cheng19 eq. 18]")
      .value("null_space", Fusion::null_space, "[Cheng19 eq. 19, 20], dynamically consistent")
      .value("null_space_at_rest", Fusion::null_space_at_rest, "[Cheng19 eq. 19, 20] with Moore-Penrose inverses")
      .value("quadratic", Fusion::quadratic, "a quadratic programme a level, within the limits");
  nb::enum_<Inverse>(module, "Inverse", "The generalised inverse of [Cheng19 eq. 20].")
      .value("dynamically_consistent", Inverse::dynamically_consistent, "lower tasks accelerate no higher one")
      .value("moore_penrose", Inverse::moore_penrose, "so at rest alone");
  nb::enum_<LimitForm>(module, "LimitForm", "How limits of position and velocity are written.")
      .value("acceleration", LimitForm::acceleration, "rad/s^2 that still stop before them")
      .value("paper", LimitForm::paper, "[Cheng19 eq. 27] as printed");
  nb::class_<Damping>(module, "Damping", "Below the threshold directions are protected by s^2 / (s^2 + damping^2 ...).")
      .def(
          "__init__", [](Damping* self, double threshold, double damping) { new (self) Damping{threshold, damping}; },
          "threshold"_a = 0.02, "damping"_a = 0.02)
      .def_rw("threshold", &Damping::threshold, "1/sqrt(kg), or m/rad at rest: singular value")
      .def_rw("damping", &Damping::damping, "of the same unit, where the singular value is 0");
  nb::class_<QuadraticLimits>(module, "QuadraticLimits", "Position, velocity and torque limits of the programmes.")
      .def_static("of", &QuadraticLimits::of, "robot"_a, "braking"_a = 10.0,
                  "Those of a robot, which brakes with `braking` rad/s^2.")
      .def_rw("lower", &QuadraticLimits::lower, "(n,) rad")
      .def_rw("upper", &QuadraticLimits::upper, "(n,) rad")
      .def_rw("velocity", &QuadraticLimits::velocity, "(n,) rad/s")
      .def_rw("torque", &QuadraticLimits::torque, "(n,) Nm")
      .def_rw("braking", &QuadraticLimits::braking, "(n,) rad/s^2, on which stopping before a position limit counts")
      .def_rw("margin_rad", &QuadraticLimits::margin_rad, "rad, kept from the position limits")
      .def_rw("horizon_s", &QuadraticLimits::horizon_s, "s, in which a velocity beyond its bound is to come back")
      .def_rw("form", &QuadraticLimits::form, "how position and velocity limits are written")
      .def_rw("position_rate", &QuadraticLimits::position_rate, "lambda of [Cheng19 eq. 27], Nm/rad")
      .def_rw("velocity_rate", &QuadraticLimits::velocity_rate, "mu of [Cheng19 eq. 27], Nm s/rad")
      .def_rw("steps", &QuadraticLimits::steps,
              "solver steps that one tick may take, 12 a joint at least where limits seem to exclude each other")
      .def_rw("fade_s", &QuadraticLimits::fade_s, "s, how long a difference fades that the end of the steps made");
  nb::class_<FusionReport>(module, "FusionReport", "How the work of a tick's fusion ended.")
      .def_ro("steps", &FusionReport::steps, "of the solver, in this tick")
      .def_ro("room_steps", &FusionReport::room_steps, "of these, to find a torque within all limits")
      .def_ro("fallback", &FusionReport::fallback, "the steps, or the time, ended before all levels were exact")
      .def_ro("by_clock", &FusionReport::by_clock, "it was the time")
      .def_ro("fade_limited", &FusionReport::fade_limited, "a limit forbade that the torque went on without a step")
      .def_ro("widened", &FusionReport::widened,
              "no torque keeps all limits: those of acceleration gave way, those of torque did not")
      .def_ro("finished", &FusionReport::finished, "levels that are exact, from the highest on");
  nb::class_<StackEntry>(module, "StackEntry", "A task, its level (0 the highest, -1 outside of levels) and weight.")
      .def(
          "__init__",
          [](StackEntry* self, std::shared_ptr<Task> task, int level, double weight) {
            new (self) StackEntry{std::move(task), level, weight};
          },
          "task"_a, "level"_a = 0, "weight"_a = 1.0)
      .def_ro("task", &StackEntry::task, "the Task")
      .def_ro("level", &StackEntry::level, "0 the highest; FEEDFORWARD: outside of levels")
      .def_ro("weight", &StackEntry::weight, "among tasks of a weighted sum");
  module.attr("FEEDFORWARD") = StackEntry::feedforward;
  nb::class_<TaskStack>(module, "TaskStack", "Which tasks, on which levels, fused in which way.")
      .def(nb::init<std::size_t, std::vector<StackEntry>, Fusion, Damping, std::optional<QuadraticLimits>>(),
           "joint_count"_a, "entries"_a, "fusion"_a, "damping"_a = Damping{}, "limits"_a = nb::none())
      .def(
          "compute",
          [](TaskStack& self, const RobotDynamics& dynamics, Doubles position, Doubles velocity,
             const skin::SkinState& skin, Shares share, double period_s) {
            std::vector<double> fused(self.joint_count());
            with_input(dynamics, position, velocity, skin, share, period_s, [&](const TaskInput& input) {
              require(self.compute(input, dynamics.mass_matrix(), dynamics.nonlinear_effects(), fused),
                      "the stack has no answer to this state");
            });
            return copy_of(std::span<const double>(fused));
          },
          "dynamics"_a, "position"_a, "velocity"_a, "skin"_a, "share"_a, "period_s"_a = 0.001,
          "(n) Nm, for a robot without added inertia or friction.")
      .def(
          "start",
          [](TaskStack& self, const RobotDynamics& dynamics, Doubles position, Doubles velocity,
             const skin::SkinState& skin, Shares share, double period_s) {
            with_input(dynamics, position, velocity, skin, share, period_s,
                       [&](const TaskInput& input) { self.start(input, nullptr); });
          },
          "dynamics"_a, "position"_a, "velocity"_a, "skin"_a, "share"_a, "period_s"_a = 0.001,
          "Lets all tasks begin where the robot is: position (n) rad, velocity (n) rad/s.")
      .def_prop_ro("fusion", &TaskStack::fusion, "the Fusion")
      .def_prop_ro("report", &TaskStack::report, "how a quadratic fusion ended the last compute");

  using Levels = std::vector<std::pair<Doubles, Rows>>;
  const auto spans = [](const Levels& levels, std::size_t joints) {
    std::vector<control::FusionLevel> result;
    for (const auto& [torque, rows] : levels) {
      require(torque.shape(0) == joints && rows.shape(1) == joints, "levels must have one column a joint");
      result.push_back({span_of(torque), {rows.data(), rows.size()}});
    }
    return result;
  };
  nb::class_<NullSpaceFusion>(module, "NullSpaceFusion",
                              "Strict hierarchy by recursive null spaces [Cheng19 eq. 19, 20].")
      .def(nb::init<std::size_t, std::size_t, Inverse, Damping>(), "joint_count"_a, "largest_rows"_a, "inverse"_a,
           "damping"_a = Damping{})
      .def(
          "fuse",
          [spans](NullSpaceFusion& self, Rows mass, const Levels& levels) {
            std::vector<double> fused(mass.shape(0));
            require(self.fuse({mass.data(), mass.size()}, spans(levels, fused.size()), fused),
                    "mass and levels must have one column a joint, mass must be positive definite");
            return copy_of(std::span<const double>(fused));
          },
          "mass"_a, "levels"_a, "(n) Nm from mass (n, n) and levels [(torque (n), rows (s, n))], the highest first.");
  // (n) Nm that `fuse`, told the input and where the torque goes, makes; false from it raises an error with the
  // message.
  const auto fused_by = [](const RobotDynamics& dynamics, Doubles position, Doubles velocity, Doubles feedforward,
                           const char* otherwise, const auto& fuse) {
    const std::size_t joints = dynamics.joint_count();
    std::vector<double> fused(joints);
    const skin::SkinState none;
    require(position.shape(0) == joints && velocity.shape(0) == joints && feedforward.shape(0) == joints,
            "arrays must have one entry a joint");
    require(fuse(TaskInput{dynamics, span_of(position), span_of(velocity), none, {}, 0.001}, fused), otherwise);
    return copy_of(std::span<const double>(fused));
  };
  nb::class_<QuadraticFusion>(module, "QuadraticFusion", "Strict hierarchy by quadratic programmes within the limits.")
      .def(nb::init<std::size_t, std::size_t, std::size_t, QuadraticLimits>(), "joint_count"_a, "largest_rows"_a,
           "levels"_a, "limits"_a)
      .def(
          "fuse",
          [spans, fused_by](QuadraticFusion& self, const RobotDynamics& dynamics, Doubles position, Doubles velocity,
                            Doubles feedforward, const Levels& levels) {
            return fused_by(dynamics, position, velocity, feedforward, "the programmes have no finite answer",
                            [&](const TaskInput& input, std::vector<double>& fused) {
                              return self.fuse(input, dynamics.mass_matrix(), dynamics.nonlinear_effects(),
                                               span_of(feedforward), spans(levels, fused.size()), fused);
                            });
          },
          "dynamics"_a, "position"_a, "velocity"_a, "feedforward"_a, "levels"_a,
          "(n) Nm, feedforward (n) included; see NullSpaceFusion.fuse.")
      .def(
          "fuse_weighted",
          [fused_by](QuadraticFusion& self, const RobotDynamics& dynamics, Doubles position, Doubles velocity,
                     Doubles feedforward, const std::vector<std::tuple<double, Rows, Doubles>>& terms) {
            std::vector<control::WeightedRows> all;
            for (const auto& [weight, rows, acceleration] : terms)
              all.push_back({{rows.data(), rows.size()}, span_of(acceleration), weight});
            return fused_by(
                dynamics, position, velocity, feedforward,
                "rows must be (rows, n) and accelerations (rows), no more than the largest, weights not negative",
                [&](const TaskInput& input, std::vector<double>& fused) {
                  return self.fuse_weighted(input, dynamics.mass_matrix(), dynamics.nonlinear_effects(),
                                            span_of(feedforward), all, fused);
                });
          },
          "dynamics"_a, "position"_a, "velocity"_a, "feedforward"_a, "terms"_a,
          "(n) Nm, feedforward (n) included, of one programme without a hierarchy: terms are (weight, rows (rows, n),\n"
          "acceleration (rows)).")
      .def_prop_ro("constrained", &QuadraticFusion::constrained, "levels of the last fuse that met a limit")
      .def_prop_ro("report", &QuadraticFusion::report, "FusionReport of the last fuse")
      .def("set_steps", &QuadraticFusion::set_steps, "steps"_a, "How many solver steps a tick may take from now on.")
      .def_prop_ro("claimed", &QuadraticFusion::claimed, "directions that its levels took");
  module.attr("QUADRATIC_TOLERANCE") = QuadraticFusion::tolerance;
}

}  // namespace robotskin::bindings
