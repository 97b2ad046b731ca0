// SPDX-License-Identifier: Apache-2.0
// Binds the control stage.
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/vector.h>

#include "bindings/arrays.hpp"
#include "bindings/bindings.hpp"
#include "control/control_error.hpp"
#include "control/joint_task.hpp"
#include "control/torque_resolver.hpp"
#include "control/touch_wrench.hpp"
#include "control/virtual_robot.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::bindings {
namespace {

using control::TorqueResolver;
using control::TouchMatrix;
using control::TouchWrench;
using Doubles = InputArray<double>;

void require(bool accepted, const char* what) {
  if (!accepted) throw std::invalid_argument(what);
}

nb::ndarray<nb::numpy, double> owned(const std::vector<double>& values) {
  return copy_of(std::span<const double>(values));
}

void bind_gains(nb::module_& module) {
  using control::InnerLoopGains;
  using control::JointGains;
  using control::ResolverGains;
  using control::SkinGains;
  using control::VirtualRobotGains;
  nb::class_<JointGains>(module, "JointGains", "Impedance of the joint task, one entry a joint.")
      .def(nb::init<std::vector<double>, std::vector<double>>(), "stiffness"_a, "damping"_a)
      .def_rw("stiffness", &JointGains::stiffness, "(n) Nm/rad")
      .def_rw("damping", &JointGains::damping, "(n) Nm s/rad");
  nb::class_<SkinGains>(module, "SkinGains", "Weights and thresholds of the skin task, one entry a cell.")
      .def(nb::init<std::vector<float>, std::vector<float>, std::vector<float>, std::vector<float>, std::vector<float>,
                    std::vector<float>>(),
           "force_weight"_a, "proximity_weight"_a, "force_silent"_a, "force_full"_a, "proximity_silent"_a,
           "proximity_full"_a)
      .def_static("uniform", &SkinGains::uniform, "cells"_a, "force_weight"_a, "proximity_weight"_a, "force_silent"_a,
                  "force_full"_a, "proximity_silent"_a, "proximity_full"_a, "The same numbers for every cell.")
      .def("measured_force", &SkinGains::measured_force, "Weight 1 on force and none on proximity: the force felt.")
      .def_rw("force_weight", &SkinGains::force_weight, "(N) newton asked for a newton felt (w_f of [Cheng19 eq. 14])")
      .def_rw("proximity_weight", &SkinGains::proximity_weight,
              "(N) newton at full-scale proximity (w_p of [Cheng19 eq. 14])")
      .def_rw("force_silent", &SkinGains::force_silent, "(N) newton, sum of three sensors, below which nothing acts")
      .def_rw("force_full", &SkinGains::force_full, "(N) newton from which all of it acts")
      .def_rw("proximity_silent", &SkinGains::proximity_silent, "(N) 0 to 1")
      .def_rw("proximity_full", &SkinGains::proximity_full, "(N) 0 to 1");
  nb::class_<VirtualRobotGains>(module, "VirtualRobotGains", "What the virtual robot has beside the robot's own model.")
      .def(nb::init<std::vector<double>, std::vector<double>>(), "inertia"_a, "friction"_a)
      .def_rw("inertia", &VirtualRobotGains::inertia, "(n) kg m^2")
      .def_rw("friction", &VirtualRobotGains::friction, "(n) Nm s/rad");
  nb::class_<InnerLoopGains>(module, "InnerLoopGains", "Inner velocity loop of the torque resolver.")
      .def(nb::init<std::vector<double>, std::vector<double>, std::vector<double>>(), "proportional"_a, "integral"_a,
           "derivative"_a)
      .def_rw("proportional", &InnerLoopGains::proportional, "(n) 1/s")
      .def_rw("integral", &InnerLoopGains::integral, "(n) 1/s^2")
      .def_rw("derivative", &InnerLoopGains::derivative, "(n)")
      .def_rw("dead_zone_rad_s", &InnerLoopGains::dead_zone_rad_s, "rad/s, velocity errors below it are none")
      .def_rw("estimator_hz", &InnerLoopGains::estimator_hz,
              "Hz, below which the velocity estimate follows the real robot")
      .def_rw("largest_bias", &InnerLoopGains::largest_bias, "rad/s");
  nb::class_<ResolverGains>(module, "ResolverGains", "Torque resolver: virtual robot, inner loop, blending.")
      .def(
          "__init__",
          [](ResolverGains* self, VirtualRobotGains virtual_robot, InnerLoopGains inner_loop) {
            new (self) ResolverGains{std::move(virtual_robot), std::move(inner_loop)};
          },
          "virtual_robot"_a, "inner_loop"_a)
      .def_rw("virtual_robot", &ResolverGains::virtual_robot,
              "of the robot that stands in where the interface feels no touch")
      .def_rw("inner_loop", &ResolverGains::inner_loop, "of the velocity that the velocity interface commands")
      .def_rw("period_s", &ResolverGains::period_s, "s, of one tick")
      .def_rw("switch_time_s", &ResolverGains::switch_time_s, "s, how long a change of interface is blended")
      .def_rw("largest_lead_rad", &ResolverGains::largest_lead_rad,
              "rad, how far the virtual robot may run ahead of the real one")
      .def_rw("position_bias_per_s", &ResolverGains::position_bias_per_s,
              "1/s, how fast the static error of a position servo is removed")
      .def_rw("largest_bias_rad", &ResolverGains::largest_bias_rad, "rad, bound of that correction")
      .def_rw("torque_bias_per_s", &ResolverGains::torque_bias_per_s,
              "1/s, how fast the torque interface makes up for what the model does not know")
      .def_rw("largest_bias_effort_share", &ResolverGains::largest_bias_effort_share,
              "bound of that torque, as a share of each joint's effort limit")
      .def_rw("servo_lag_s", &ResolverGains::servo_lag_s,
              "s, first time constant of the position servo, by which commands lead")
      .def_rw("servo_lag_s2", &ResolverGains::servo_lag_s2, "s^2, the second one");
}

void bind_touch(nb::module_& module) {
  nb::class_<TouchMatrix>(module, "TouchMatrix",
                          "What a unit touch of each cell does to its body: constant, shared by touches of any gains.")
      .def(nb::init<const RobotModel&, const skin::SkinModel&>(), "robot"_a, "skin"_a,
           "Raises ModelError for an unknown link.")
      .def_prop_ro("cell_count", &TouchMatrix::cell_count, "N of the skin")
      .def_prop_ro("body_count", &TouchMatrix::body_count, "joints whose links have cells");
  nb::class_<TouchWrench>(
      module, "TouchWrench",
      "What a touch does to each body, and the joint torques that follow [Cheng19 eq. 14 to 17], by "
      "[Cheng19 eq. 22 to 25]. Tasks that are given the same one share what it computes in a tick.")
      .def(nb::init<const RobotModel&, const skin::SkinModel&, const control::SkinGains&>(), "robot"_a, "skin"_a,
           "gains"_a, "Raises ModelError for an unknown link, ControlError for gains that do not fit the skin.")
      .def(nb::init<std::shared_ptr<const TouchMatrix>, const control::SkinGains&>(), "matrix"_a, "gains"_a,
           "Raises ControlError for gains that do not fit the matrix.")
      .def_prop_ro("cell_count", &TouchWrench::cell_count, "N of the skin")
      .def(
          "compute",
          [](TouchWrench& self, const RobotDynamics& dynamics, const skin::SkinState& state, InputArray<float> share) {
            require(self.compute(dynamics, state, span_of(share)),
                    "state and share must have one entry a cell, dynamics must be of the same robot");
            return copy_of(self.torque());
          },
          "dynamics"_a, "state"_a, "share"_a,
          "(n) Nm at the posture of the dynamics; share (N) float32, 0 masks a cell.")
      .def_prop_ro(
          "torque", [](const TouchWrench& self) { return copy_of(self.torque()); }, nb::rv_policy::move,
          "(n) Nm of the last compute")
      .def_prop_ro(
          "magnitudes", [](const TouchWrench& self) { return copy_of(self.magnitudes()); }, nb::rv_policy::move,
          "(N) newton, float32, what each cell asked for in the last compute")
      .def_prop_ro(
          "joint_wrenches",
          [](const TouchWrench& self) { return copy_of(self.joint_wrenches(), {self.joint_count(), 6}); },
          nb::rv_policy::move,
          "(n, 6) force and moment about the joint's origin, in the joint's frame, of the last compute.");
}

void bind_resolver(nb::module_& module) {
  nb::class_<control::VirtualRobot>(module, "VirtualRobot", "(M + I) a + C v + g + B v = torque.")
      .def(nb::init<control::VirtualRobotGains, std::size_t>(), "gains"_a, "joint_count"_a)
      .def(
          "acceleration",
          [](control::VirtualRobot& self, const RobotDynamics& dynamics, Doubles velocity, Doubles torque,
             double period_s) {
            const std::size_t joints = self.gains().inertia.size();
            require(dynamics.joint_count() == joints && velocity.shape(0) == joints && torque.shape(0) == joints,
                    "arrays must have one entry a joint");
            std::vector<double> acceleration(joints);
            require(self.acceleration(dynamics, span_of(velocity), span_of(torque), period_s, acceleration),
                    "no finite acceleration follows from these values");
            return owned(acceleration);
          },
          "dynamics"_a, "velocity"_a, "torque"_a, "period_s"_a, "(n) rad/s^2, friction taken at the period's end.");
  nb::class_<TorqueResolver>(module, "TorqueResolver", "One fused torque in, a command for any of the interfaces out.")
      .def(nb::init<const RobotModel&, control::ResolverGains>(), "robot"_a, "gains"_a)
      .def("reset", &TorqueResolver::reset, "joints"_a, "Forgets the past: the virtual robot is at this JointState.")
      .def(
          "begin",
          [](TorqueResolver& self, const JointState& joints, const std::vector<CommandMode>& modes) {
            require(modes.size() == self.position().size(), "there must be one mode a joint");
            self.begin(joints, modes);
          },
          "joints"_a, "modes"_a, "Goes on through these CommandModes (n), from this JointState.")
      .def_prop_ro(
          "position", [](const TorqueResolver& self) { return copy_of(self.position()); }, nb::rv_policy::move,
          "(n) rad, of the virtual robot")
      .def_prop_ro(
          "velocity", [](const TorqueResolver& self) { return copy_of(self.velocity()); }, nb::rv_policy::move,
          "(n) rad/s, of the virtual robot")
      .def(
          "resolve",
          [](TorqueResolver& self, const RobotDynamics& dynamics, Doubles fused, Doubles touch,
             const JointState& joints, JointCommand& command) {
            const std::size_t count = dynamics.joint_count();
            require(fused.shape(0) == count && touch.shape(0) == count && command.value.size() == count,
                    "arrays must have one entry a joint");
            require(self.resolve(dynamics, span_of(fused), span_of(touch), joints, command),
                    "no finite command follows from these values");
          },
          "dynamics"_a, "fused"_a, "touch"_a, "joints"_a, "command"_a, "Fills the command from torques (n) Nm.");
}

}  // namespace

void bind_control(nb::module_ module) {
  error_class<control::ControlError>(module, "ControlError", "Gains, tasks or levels that do not fit together.");
  bind_gains(module);
  bind_touch(module);
  bind_resolver(module);
  bind_control_tasks(module);
  bind_control_propagation(module);
  bind_control_fusion(module);
}

}  // namespace robotskin::bindings
