// SPDX-License-Identifier: Apache-2.0
// Binds the model stage. Results come as copies, because a view would change with the next update.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <initializer_list>
#include <stdexcept>
#include <string>

#include "bindings/bindings.hpp"
#include "bindings/python_port.hpp"
#include "model/joint_command.hpp"
#include "model/joint_state.hpp"
#include "model/robot_dynamics.hpp"
#include "model/robot_model.hpp"
#include "model/robot_port.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::bindings {
namespace {

using InputVector = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

template <typename Value>
nb::ndarray<nb::numpy, Value> copied(std::span<const Value> values, std::initializer_list<std::size_t> shape) {
  auto* data = new Value[values.size() == 0 ? 1 : values.size()];
  std::copy(values.begin(), values.end(), data);
  nb::capsule owner(data, [](void* memory) noexcept { delete[] static_cast<Value*>(memory); });
  return nb::ndarray<nb::numpy, Value>(data, shape.size(), shape.begin(), owner);
}

std::vector<std::string> names(std::span<const std::string> values) {
  return {values.begin(), values.end()};
}

std::span<const double> as_span(const InputVector& vector) {
  return {vector.data(), vector.shape(0)};
}

void require(bool accepted, const char* what) {
  if (!accepted) throw std::invalid_argument(what);
}

// A vector of a state or command as a numpy array that shares its memory, and that can be assigned from one.
template <auto member, typename Owner>
void bind_vector(nb::class_<Owner>& owner, const char* name, const char* doc) {
  owner.def_prop_rw(
      name,
      [](nb::handle_t<Owner> self) {
        std::vector<double>& vector = nb::cast<Owner&>(self).*member;
        return nb::ndarray<nb::numpy, double>(vector.data(), {vector.size()}, self);
      },
      [](Owner& self, InputVector values) {
        std::vector<double>& vector = self.*member;
        if (values.shape(0) != vector.size())
          throw std::invalid_argument(std::to_string(values.shape(0)) + " entries given, there are " +
                                      std::to_string(vector.size()) + " joints");
        std::copy_n(values.data(), vector.size(), vector.data());
      },
      doc, nb::for_getter(nb::rv_policy::automatic));
}

void bind_states(nb::module_& module) {
  module.attr("NEVER_NS") = never_ns;
  auto state = nb::class_<JointState>(module, "JointState", "Measured joints: rad, rad/s, Nm; m, m/s, N if prismatic.")
                   .def(nb::init<std::size_t>(), "joint_count"_a)
                   .def_prop_ro("joint_count", &JointState::joint_count, "n of the arrays")
                   .def("__repr__",
                        [](const JointState& self) {
                          return "<JointState of " + std::to_string(self.joint_count()) + " joints, at " +
                                 std::to_string(self.stamp_ns) + " ns>";
                        })
                   .def_rw("stamp_ns", &JointState::stamp_ns, "Host clock when measured; NEVER_NS if never.");
  bind_vector<&JointState::position>(state, "position", "(n) rad");
  bind_vector<&JointState::velocity>(state, "velocity", "(n) rad/s");
  bind_vector<&JointState::effort>(state, "effort", "(n) Nm, measured, positive along the joint's axis");

  nb::enum_<CommandMode>(module, "CommandMode", "The interface a command goes through.")
      .value("position", CommandMode::position)
      .value("velocity", CommandMode::velocity)
      .value("torque", CommandMode::torque);
  auto command = nb::class_<JointCommand>(module, "JointCommand", "What the joints are told for one cycle.")
                     .def(nb::init<CommandMode, std::size_t>(), "mode"_a, "joint_count"_a)
                     .def_prop_ro("joint_count", &JointCommand::joint_count, "n of `value`")
                     .def_prop_rw(
                         "mode", [](const JointCommand& self) { return self.common_mode(); },
                         [](JointCommand& self, CommandMode mode) { std::ranges::fill(self.mode, mode); },
                         "the CommandMode that `value` is for; None where joints have their own")
                     .def_prop_rw(
                         "modes", [](const JointCommand& self) { return self.mode; },
                         [](JointCommand& self, std::vector<CommandMode> modes) {
                           if (modes.size() != self.joint_count())
                             throw std::invalid_argument("there must be one mode a joint");
                           self.mode = std::move(modes);
                         },
                         "(n) the CommandMode of each joint");
  bind_vector<&JointCommand::value>(command, "value", "(n) rad, rad/s or Nm by mode");

  nb::enum_<PortStatus>(module, "PortStatus", "How a robot answered a read or a write.")
      .value("ok", PortStatus::ok)
      .value("no_new_state", PortStatus::no_new_state)
      .value("refused", PortStatus::refused)
      .value("disconnected", PortStatus::disconnected);
}

void bind_robot_port(nb::module_& module) {
  nb::class_<SensorPlace>(module, "SensorPlace", "Where a sensor is: its name, and the link that carries it.")
      .def(
          "__init__",
          [](SensorPlace* self, std::string name, std::string link) {
            new (self) SensorPlace{.name = std::move(name), .link = std::move(link)};
          },
          "name"_a, "link"_a)
      .def_ro("name", &SensorPlace::name, "of the sensor")
      .def_ro("link", &SensorPlace::link, "that carries it")
      .def_prop_rw(
          "link_from_sensor",
          [](const SensorPlace& self) { return copied(std::span<const double>(self.link_from_sensor), {4, 4}); },
          [](SensorPlace& self, nb::ndarray<const double, nb::shape<4, 4>, nb::c_contig, nb::device::cpu> pose) {
            std::copy_n(pose.data(), 16, self.link_from_sensor.begin());
          },
          "(4, 4) metres", nb::for_getter(nb::rv_policy::move));
  nb::class_<PortSensors>(module, "PortSensors", "Which sensors a robot has beside its joints; constant.")
      .def(
          "__init__",
          [](PortSensors* self, std::vector<SensorPlace> imus, std::vector<SensorPlace> forces) {
            new (self) PortSensors{std::move(imus), std::move(forces)};
          },
          "imus"_a = std::vector<SensorPlace>{}, "forces"_a = std::vector<SensorPlace>{})
      .def_ro("imus", &PortSensors::imus, "SensorPlace of each inertial unit")
      .def_ro("forces", &PortSensors::forces, "SensorPlace of each force sensor");
  nb::class_<ImuReading>(module, "ImuReading", "What is not measured is NaN, with a stamp of NEVER_NS, and never zero.")
      .def_rw("acceleration", &ImuReading::acceleration, "(3) m/s^2, specific force, sensor frame")
      .def_rw("angular_velocity", &ImuReading::angular_velocity, "(3) rad/s, sensor frame")
      .def_rw("up_from_sensor", &ImuReading::up_from_sensor, "(9) row-major, from the sensor's frame to one with z up")
      .def_rw("stamp_ns", &ImuReading::stamp_ns, "host clock when measured");
  nb::class_<ForceReading>(module, "ForceReading",
                           "What acts on the robot at a sensor. What is not measured is NaN, with a stamp of NEVER_NS.")
      .def_rw("force", &ForceReading::force, "(3) newton, sensor frame")
      .def_rw("moment", &ForceReading::moment, "(3) Nm about the sensor's origin")
      .def_rw("stamp_ns", &ForceReading::stamp_ns, "host clock when measured");
  nb::class_<SensorReadings>(module, "SensorReadings", "One entry a sensor, in the order of PortSensors.")
      .def(nb::init<const PortSensors&>(), "sensors"_a)
      .def_prop_ro(
          "imus",
          [](nb::handle_t<SensorReadings> self) {
            nb::list readings;
            for (ImuReading& one : nb::cast<SensorReadings&>(self).imus)
              readings.append(nb::cast(&one, nb::rv_policy::reference_internal, self));
            return readings;
          },
          nb::sig("def imus(self) -> list[ImuReading]"), "of each inertial unit")
      .def_prop_ro(
          "forces",
          [](nb::handle_t<SensorReadings> self) {
            nb::list readings;
            for (ForceReading& one : nb::cast<SensorReadings&>(self).forces)
              readings.append(nb::cast(&one, nb::rv_policy::reference_internal, self));
            return readings;
          },
          nb::sig("def forces(self) -> list[ForceReading]"), "of each force sensor");

  nb::class_<RobotPort, PythonPort>(
      module, "RobotPort",
      R"(The one interface through which anything moves a robot; derive from it for your own.

Override `read(state) -> PortStatus`: fill `position`, `velocity`, `effort` and `stamp_ns` of the JointState, (n) each;
`write(command) -> PortStatus`: give the JointCommand to the robot, which holds it for 20 ms at most; `stop()`: bring the
robot to rest and keep it there against gravity, whatever was commanded before; and, with `sensors`,
`read_sensors(readings) -> PortStatus`. A port that raises counts as disconnected: the robot is told to stop.)")
      .def(nb::init<std::size_t, std::vector<CommandMode>, PortSensors, bool, bool>(), "joint_count"_a, "modes"_a,
           "sensors"_a = PortSensors{}, "by_joint"_a = false, "smooths_positions"_a = false,
           "modes: the interfaces that the robot offers; by_joint: each joint may have its own; smooths_positions: "
           "`stop` brings it to rest sooner than positions can.")
      .def_prop_ro("sensors", &RobotPort::sensors, "which sensors the robot has beside its joints")
      .def("read_sensors", &RobotPort::read_sensors, "readings"_a, "Fills what is new; `no_new_state`: nothing is.")
      .def_prop_ro("joint_count", &RobotPort::joint_count, "n of its states and commands")
      .def(
          "offers", [](const RobotPort& self, std::optional<CommandMode> mode) { return mode && self.offers(*mode); },
          "mode"_a.none(),
          "Whether commands of all joints may go through this interface; None: of each its own, never.")
      .def_prop_ro("offers_by_joint", &RobotPort::offers_by_joint,
                   "whether each joint may be commanded through an interface of its own")
      .def_prop_ro("smooths_positions", &RobotPort::smooths_positions,
                   "whether `stop` brings it to rest sooner than positions can, which it smooths")
      .def("read", &RobotPort::read, "state"_a, "Fills the state; `no_new_state` leaves it as it was.")
      .def("write", &RobotPort::write, "command"_a, "Holds until the next write or stop.")
      .def_prop_ro("period_s", &RobotPort::period_s,
                   "between two states, where the port tells each as it comes; else 0")
      .def("stop", &RobotPort::stop, "Brings the robot to rest and keeps it there against gravity.");
}

void bind_robot_model(nb::module_& module) {
  error_class<ModelError>(module, "ModelError", "A robot that cannot be modelled, or a joint or link that it lacks.");
  module.attr("BASE") = RobotModel::base;
  module.attr("UNBOUNDED") = RobotModel::unbounded;
  nb::enum_<JointKind>(module, "JointKind", "How a joint moves.")
      .value("revolute", JointKind::revolute, "turns about its axis, rad")
      .value("prismatic", JointKind::prismatic, "slides along its axis, m");

  nb::class_<RobotModel>(module, "RobotModel",
                         "What is constant about a robot of n joints and l links on a fixed base.\n\n"
                         "Lengths in m, angles in rad. Joints come before their children, the base link comes first.")
      .def(nb::init<const std::string&, const RobotModel::RotorInertia&>(), "urdf"_a,
           "rotor_inertia"_a = RobotModel::RotorInertia{},
           "Reads the text of a URDF (robotskin.robots repairs one); raises ModelError.\n\n"
           "`rotor_inertia`: kg m^2 or kg by name of the joint, as the joint feels it through its gears.")
      .def_prop_ro("name", &RobotModel::name, "as the URDF says")
      .def_prop_ro("joint_count", &RobotModel::joint_count, "n, joints that move")
      .def_prop_ro("link_count", &RobotModel::link_count, "l, the base link counted")
      .def_prop_ro(
          "joint_names", [](const RobotModel& self) { return names(self.joint_names()); }, "(n)")
      .def_prop_ro(
          "link_names", [](const RobotModel& self) { return names(self.link_names()); }, "(l), the base first")
      .def_prop_ro(
          "joint_parents", [](const RobotModel& self) { return copied(self.joint_parents(), {self.joint_count()}); },
          nb::rv_policy::move, "(n) index of the joint above, or BASE")
      .def_prop_ro(
          "joint_kinds",
          [](const RobotModel& self) {
            return std::vector<JointKind>(self.joint_kinds().begin(), self.joint_kinds().end());
          },
          "(n) JointKind")
      .def_prop_ro(
          "joint_axes", [](const RobotModel& self) { return copied(self.joint_axes(), {self.joint_count(), 3}); },
          nb::rv_policy::move, "(n, 3) unit vectors in the joint's frame")
      .def_prop_ro(
          "parent_from_joint",
          [](const RobotModel& self) { return copied(self.parent_from_joint(), {self.joint_count(), 4, 4}); },
          nb::rv_policy::move, "(n, 4, 4) with the joint at zero")
      .def_prop_ro(
          "lower", [](const RobotModel& self) { return copied(self.lower(), {self.joint_count()}); },
          nb::rv_policy::move, "(n) rad or m, -inf if unbounded")
      .def_prop_ro(
          "upper", [](const RobotModel& self) { return copied(self.upper(), {self.joint_count()}); },
          nb::rv_policy::move, "(n) rad or m, inf if unbounded")
      .def_prop_ro(
          "velocity_limit", [](const RobotModel& self) { return copied(self.velocity_limit(), {self.joint_count()}); },
          nb::rv_policy::move, "(n) rad/s or m/s")
      .def("actuated", &RobotModel::actuated, "joint"_a,
           "Whether a motor drives the joint; the six joints of a floating base alone have none.")
      .def_prop_ro(
          "effort_limit", [](const RobotModel& self) { return copied(self.effort_limit(), {self.joint_count()}); },
          nb::rv_policy::move, "(n) Nm or N")
      .def_prop_ro(
          "joint_damping", [](const RobotModel& self) { return copied(self.joint_damping(), {self.joint_count()}); },
          nb::rv_policy::move, "(n) Nm s/rad or N s/m")
      .def_prop_ro(
          "rotor_inertia", [](const RobotModel& self) { return copied(self.rotor_inertia(), {self.joint_count()}); },
          nb::rv_policy::move, "(n) kg m^2 or kg, part of the mass matrix")
      .def_prop_ro(
          "link_joints", [](const RobotModel& self) { return copied(self.link_joints(), {self.link_count()}); },
          nb::rv_policy::move, "(l) index of the joint that carries the link, or BASE")
      .def_prop_ro(
          "joint_from_link",
          [](const RobotModel& self) { return copied(self.joint_from_link(), {self.link_count(), 4, 4}); },
          nb::rv_policy::move, "(l, 4, 4) constant")
      .def("joint_index", &RobotModel::joint_index, "joint"_a, "Raises ModelError for an unknown name.")
      .def("link_index", &RobotModel::link_index, "link"_a, "Raises ModelError for an unknown name.");
}

void bind_robot_dynamics(nb::module_& module) {
  using Dynamics = RobotDynamics;
  nb::class_<Dynamics>(module, "RobotDynamics",
                       "Where the links are and how the robot answers to forces, at the last update.\n\n"
                       "All in the base frame, SI units: M(q) a + C(q, v) v + g(q) = torque.")
      .def(nb::init<const RobotModel&>(), "model"_a)
      .def_prop_ro("joint_count", &Dynamics::joint_count, "n")
      .def_prop_ro("link_count", &Dynamics::link_count, "l")
      .def(
          "update",
          [](Dynamics& self, InputVector q, InputVector v) {
            if (q.shape(0) != self.joint_count() || v.shape(0) != self.joint_count())
              throw std::invalid_argument("q has " + std::to_string(q.shape(0)) + " entries and v has " +
                                          std::to_string(v.shape(0)) + ": the robot has " +
                                          std::to_string(self.joint_count()) + " joints");
            require(self.update(as_span(q), as_span(v)), "q and v must be finite");
          },
          "q"_a, "v"_a, "Computes all results for q (n) rad and v (n) rad/s; ValueError leaves them as they were.")
      .def_prop_ro(
          "base_from_joint",
          [](const Dynamics& self) { return copied(self.base_from_joint(), {self.joint_count(), 4, 4}); },
          nb::rv_policy::move, "(n, 4, 4)")
      .def_prop_ro(
          "joint_motions", [](const Dynamics& self) { return copied(self.joint_motions(), {self.joint_count(), 6}); },
          nb::rv_policy::move,
          "(n, 6) linear velocity at the base origin, then angular velocity, of a unit velocity of each joint")
      .def_prop_ro(
          "mass_matrix",
          [](const Dynamics& self) { return copied(self.mass_matrix(), {self.joint_count(), self.joint_count()}); },
          nb::rv_policy::move, "(n, n)")
      .def_prop_ro(
          "gravity_torque", [](const Dynamics& self) { return copied(self.gravity_torque(), {self.joint_count()}); },
          nb::rv_policy::move, "(n) Nm that hold the robot still")
      .def_prop_ro(
          "nonlinear_effects",
          [](const Dynamics& self) { return copied(self.nonlinear_effects(), {self.joint_count()}); },
          nb::rv_policy::move, "(n) Nm, C v + g")
      .def_prop_ro("mass", &Dynamics::mass, "kg, of all links")
      .def_prop_ro("centre_of_mass", &Dynamics::centre_of_mass, "(3) metres, of all links")
      .def_prop_ro(
          "centre_of_mass_jacobian",
          [](const Dynamics& self) {
            std::vector<double> jacobian(3 * self.joint_count());
            (void)self.centre_of_mass_jacobian(jacobian);
            return copied(std::span<const double>(jacobian), {3, self.joint_count()});
          },
          nb::rv_policy::move, "(3, n) velocity of the centre of mass per joint velocity")
      .def(
          "forward_dynamics",
          [](const Dynamics& self, InputVector torque) {
            std::vector<double> acceleration(self.joint_count());
            require(self.forward_dynamics(as_span(torque), acceleration), "torque must have one entry a joint");
            return copied(std::span<const double>(acceleration), {acceleration.size()});
          },
          "torque"_a, "(n) rad/s2 from torque (n) Nm.")
      .def(
          "solve_mass",
          [](const Dynamics& self, InputVector right_side) {
            std::vector<double> solution(self.joint_count());
            require(self.solve_mass(as_span(right_side), solution), "right_side must have one entry a joint");
            return copied(std::span<const double>(solution), {solution.size()});
          },
          "right_side"_a, "(n) M^-1 right_side.")
      .def(
          "base_from_link",
          [](const Dynamics& self, std::size_t link) {
            std::vector<double> placement(16);
            require(self.base_from_link(link, placement), "link must be below link_count");
            return copied(std::span<const double>(placement), {4, 4});
          },
          "link"_a, "(4, 4)")
      .def(
          "link_jacobian",
          [](const Dynamics& self, std::size_t link) {
            std::vector<double> jacobian(6 * self.joint_count());
            require(self.link_jacobian(link, jacobian), "link must be below link_count");
            return copied(std::span<const double>(jacobian), {6, self.joint_count()});
          },
          "link"_a, "(6, n) velocity of the link's origin, then angular velocity, along the axes of the base.");
}

}  // namespace

void bind_model(nb::module_ module) {
  bind_states(module);
  bind_robot_port(module);
  bind_robot_model(module);
  bind_robot_dynamics(module);
  bind_shared_mailbox(module);
}

}  // namespace robotskin::bindings
