// SPDX-License-Identifier: Apache-2.0
// Binds what the product is measured against: the equations taken literally, a bare product, a network that only
// stores and forwards.
#include <nanobind/stl/vector.h>

#include "baselines/naive_skin_task.hpp"
#include "baselines/plain_network.hpp"
#include "baselines/skin_task_timing.hpp"
#include "bindings/arrays.hpp"
#include "bindings/lab.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::bindings {
namespace {

using lab::NaiveSkinTask;
using lab::PlainCounts;
using Doubles = InputArray<double>;

void require(bool accepted, const char* what) {
  if (!accepted) throw std::invalid_argument(what);
}

nb::ndarray<nb::numpy, double> owned(const std::vector<double>& values) {
  return copy_of(std::span<const double>(values));
}

nb::ndarray<nb::numpy, std::int64_t> owned(const std::vector<std::int64_t>& values) {
  return copy_of(std::span<const std::int64_t>(values));
}

}  // namespace

void bind_baselines(nb::module_ module) {
  nb::class_<NaiveSkinTask>(module, "NaiveSkinTask", "The skin task with a Jacobian a cell [Cheng19 eq. 15 to 17].")
      .def(nb::init<const RobotModel&, const skin::SkinModel&>(), "robot"_a, "skin"_a)
      .def(
          "compute",
          [](NaiveSkinTask& self, const RobotDynamics& dynamics, InputArray<float> magnitude) {
            require(magnitude.shape(0) == self.cell_count(), "magnitude must have one entry a cell");
            std::vector<double> torque(dynamics.joint_count());
            self.compute(dynamics, span_of(magnitude), torque);
            return owned(torque);
          },
          "dynamics"_a, "magnitude"_a, "(n) Nm from magnitude (N) newton, float32, along each cell's -z.");
  module.def(
      "time_skin_task",
      [](const RobotModel& robot, const skin::SkinModel& skin, const control::SkinGains& gains,
         const skin::SkinState& state, const skin::SkinState& other, Doubles position, std::size_t rounds) {
        const auto times = lab::time_skin_task(robot, skin, gains, state, other, span_of(position), rounds);
        require(!times.task.empty(), "states and position must fit the skin and the robot, rounds must not be 0");
        nb::dict result;
        result["product"] = owned(times.product);
        result["single"] = owned(times.single);
        result["task"] = owned(times.task);
        result["kinematics"] = owned(times.kinematics);
        result["naive"] = owned(times.naive);
        return result;
      },
      "robot"_a, "skin"_a, "gains"_a, "state"_a, "other"_a, "position"_a, "rounds"_a,
      "Nanoseconds of each round: {'product', 'single', 'task', 'kinematics', 'naive'} (rounds), naive every tenth.");
  module.def(
      "time_dynamics_update",
      [](const RobotModel& robot, Doubles position, std::size_t rounds) {
        const auto times = lab::time_dynamics_update(robot, span_of(position), rounds);
        require(!times.empty(), "position must fit the robot, rounds must not be 0");
        return owned(times);
      },
      "robot"_a, "position"_a, "rounds"_a, "Nanoseconds of each update of the dynamics (rounds).");
  nb::class_<PlainCounts>(module, "PlainCounts", "What happened in a plain network.")
      .def_ro("made", &PlainCounts::made, "frames")
      .def_ro("hops", &PlainCounts::hops)
      .def_ro("arrived", &PlainCounts::arrived, "frames")
      .def_ro("queue_peak", &PlainCounts::queue_peak, "frames in a node at once, at most")
      .def_ro("delay_mean_us", &PlainCounts::delay_mean_us, "from making to arrival");
  module.def(
      "run_plain_network",
      [](const std::vector<std::int32_t>& next, double period_s, double duration_s, std::uint64_t seed) {
        return lab::run_plain_network(next, static_cast<std::int64_t>(1e9 * period_s),
                                      static_cast<std::int64_t>(1e9 * duration_s), seed);
      },
      "next"_a, "period_s"_a, "duration_s"_a, "seed"_a = 1, nb::call_guard<nb::gil_scoped_release>(),
      "Nodes that only store and forward frames of 50 us, on the same event queue. next: (N) node each one sends to, "
      "-1: the host.");
}

}  // namespace robotskin::bindings
