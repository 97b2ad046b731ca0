// SPDX-License-Identifier: Apache-2.0
// Binds the task library.
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bindings/arrays.hpp"
#include "bindings/bindings.hpp"
#include "bindings/python_task.hpp"
#include "bindings/task_input.hpp"
#include "control/balance_task.hpp"
#include "control/cartesian_task.hpp"
#include "control/contact_impedance_task.hpp"
#include "control/control_error.hpp"
#include "control/foot_contact_task.hpp"
#include "control/force_task.hpp"
#include "control/gravity_task.hpp"
#include "control/joint_impedance_task.hpp"
#include "control/joint_limit_task.hpp"
#include "control/joint_task.hpp"
#include "control/map_skin_task.hpp"
#include "control/self_collision_task.hpp"
#include "control/skin_cartesian_task.hpp"
#include "control/skin_reaction_task.hpp"
#include "control/spline_cartesian_task.hpp"
#include "control/spline_joint_task.hpp"
#include "control/standing_state.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::bindings {
namespace {

using control::Task;
using control::TaskInput;
using Owned = nb::ndarray<nb::numpy, double>;

Owned rows_of(const Task& task) {
  return copy_of(task.rows(), {task.row_count(), task.joint_count()});
}

std::array<double, 6> six_of(const std::vector<double>& values, const char* what) {
  std::array<double, 6> six{};
  if (values.size() != six.size())
    throw control::ControlError("Cartesian gains: " + std::string(what) + " has " + std::to_string(values.size()) +
                                " values, there are 6 axes");
  std::ranges::copy(values, six.begin());
  return six;
}

void bind_task(nb::module_& module) {
  nb::class_<Task>(module, "Task",
                   "A task: a torque on the joints, and the motions (rows) that tasks of lower levels leave alone.")
      .def_prop_ro("name", &Task::name, "of the task, in messages")
      .def_prop_ro("joint_count", &Task::joint_count, "n of `torque`")
      .def_prop_ro("largest_rows", &Task::largest_rows, "that `rows` ever has")
      .def_prop_ro(
          "torque", [](const Task& self) { return copy_of(self.torque()); }, nb::rv_policy::move, "(n) Nm")
      .def_prop_ro(
          "acceleration", [](const Task& self) { return copy_of(self.acceleration()); }, nb::rv_policy::move,
          "(rows) that the rows are to have; empty for a task that asks for a torque")
      .def_prop_ro("rows", rows_of, nb::rv_policy::move, "(rows, n)")
      .def(
          "start",
          [](Task& self, const RobotDynamics& dynamics, Doubles position, Doubles velocity, const skin::SkinState& skin,
             Shares share, double period_s) {
            with_input(dynamics, position, velocity, skin, share, period_s,
                       [&](const TaskInput& input) { self.start(input); });
          },
          "dynamics"_a, "position"_a, "velocity"_a, "skin"_a, "share"_a, "period_s"_a = 0.001,
          "Begin where the robot is; a stack calls this when the task enters it.")
      .def(
          "update",
          [](Task& self, const RobotDynamics& dynamics, Doubles position, Doubles velocity, const skin::SkinState& skin,
             Shares share, double period_s) {
            with_input(dynamics, position, velocity, skin, share, period_s, [&](const TaskInput& input) {
              require(self.update(input), "the task has no answer to this state; the skin must have its cells");
            });
          },
          "dynamics"_a, "position"_a, "velocity"_a, "skin"_a, "share"_a, "period_s"_a = 0.001,
          "One tick; the dynamics are at position (n) rad and velocity (n) rad/s, share is (N) float32.");
  nb::class_<PythonTask, Task>(
      module, "PythonTask",
      "A task computed by a Python function, for trying things out: it takes the interpreter's lock in the tick.")
      .def(nb::init<std::string, std::size_t, std::size_t, nb::callable>(), "name"_a, "joint_count"_a, "largest_rows"_a,
           "compute"_a,
           "compute(dynamics, position, velocity, skin) returns torque (n) Nm and rows (at most largest_rows, n). A "
           "task "
           "that raises stops the robot; `error` tells why.")
      .def_prop_ro("error", &PythonTask::error, "what compute raised last, empty if nothing");
}

void bind_standing_tasks(nb::module_& module) {
  using control::BalanceGains;
  using control::BalanceTask;
  using control::FootContactGains;
  using control::FootContactTask;
  using control::StandingState;
  using control::SupportPolygon;
  nb::class_<Foot>(module, "Foot", "A foot with a flat, rectangular sole, in the frame of its link.")
      .def(
          "__init__",
          [](Foot* self, std::string link, std::array<double, 3> sole, std::array<double, 2> half) {
            new (self) Foot{.link = std::move(link), .sole = sole, .half = half};
          },
          "link"_a, "sole"_a, "half"_a, "sole (3) m: middle of its lower face; half (2) m: half of length and width.")
      .def_ro("link", &Foot::link, "that carries the foot")
      .def_ro("sole", &Foot::sole, "(3) m, middle of the sole's lower face, link frame")
      .def_ro("half", &Foot::half, "(2) m, half of length and width");
  nb::class_<SupportPolygon>(module, "SupportPolygon", "The convex hull of what stands on the floor.")
      .def(nb::init<>())
      .def(
          "set", [](SupportPolygon& self, const std::vector<std::array<double, 2>>& points) { self.set(points); },
          "points"_a, "At most eight, (2) m each.")
      .def_prop_ro(
          "corners",
          [](const SupportPolygon& self) {
            return std::vector<std::array<double, 2>>(self.corners().begin(), self.corners().end());
          },
          "anticlockwise, (2) m each")
      .def_prop_ro("centre", &SupportPolygon::centre, "(2) m")
      .def("inside_by", &SupportPolygon::inside_by, "point"_a, "m from the nearest edge; negative: outside.")
      .def("clipped", &SupportPolygon::clipped, "point"_a, "margin"_a, "The nearest point inside by the margin.");
  nb::class_<StandingState>(module, "StandingState", "What is known of a standing robot's balance; world frame.")
      .def_ro("centre_of_mass", &StandingState::centre_of_mass, "(3) m")
      .def_ro("com_velocity", &StandingState::com_velocity, "(3) m/s")
      .def_ro("support", &StandingState::support, "SupportPolygon of the soles on the floor")
      .def_ro("imu_counts", &StandingState::imu_counts, "the inertial unit is heard and not stuck")
      .def_ro("forces_count", &StandingState::forces_count, "the force of each foot is heard; zmp is known")
      .def_ro("zmp", &StandingState::zmp, "(2) m, zero-moment point")
      .def_ro("load_n", &StandingState::load_n, "N, of the floor on all feet, upwards")
      .def_ro("foot_load_n", &StandingState::foot_load_n, "(2) N, of each foot")
      .def_ro("foot_pressure", &StandingState::foot_pressure, "(2, 2) m from the middle of each sole")
      .def_ro("foot_place", &StandingState::foot_place, "(2, 2) m, middle of each sole")
      .def_prop_ro("capture_point", &StandingState::capture_point, "(2) m");
  nb::class_<FootContactGains>(module, "FootContactGains", "Of a FootContactTask.")
      .def(nb::init<>())
      .def_rw("stiffness", &FootContactGains::stiffness, "1/s^2")
      .def_rw("damping", &FootContactGains::damping, "1/s")
      .def_rw("flattening", &FootContactGains::flattening, "rad/s for a newton metre")
      .def_rw("largest_turn", &FootContactGains::largest_turn, "rad");
  nb::class_<FootContactTask, Task>(module, "FootContactTask", "Feet that stand stay where they are.")
      .def(nb::init<const RobotModel&, const std::vector<Foot>&, FootContactGains>(), "robot"_a, "feet"_a,
           "gains"_a = FootContactGains{})
      .def_prop_ro("turned", &FootContactTask::turned, "(2, 2) rad about x and y, to lie flat");
  nb::class_<BalanceGains>(module, "BalanceGains", "Of a BalanceTask.")
      .def(nb::init<>())
      .def_rw("lean", &BalanceGains::lean, "share of a lasting push that leaning takes up")
      .def_rw("lean_hz", &BalanceGains::lean_hz, "Hz, how fast it leans")
      .def_rw("largest_lean_m", &BalanceGains::largest_lean_m, "m, bound of the lean")
      .def_rw("lean_feedforward", &BalanceGains::lean_feedforward, "share of the lean's own speed that is fed forward")
      .def_rw("capture", &BalanceGains::capture, "how far the zero-moment point goes beyond the capture point's error")
      .def_rw("admittance", &BalanceGains::admittance, "1/s")
      .def_rw("margin_m", &BalanceGains::margin_m, "m, by which the zero-moment point stays inside the soles")
      .def_rw("largest_speed", &BalanceGains::largest_speed, "m/s")
      .def_rw("largest_lead_m", &BalanceGains::largest_lead_m,
              "m, by which the wanted centre of mass may be ahead of the estimated one")
      .def_rw("stiffness", &BalanceGains::stiffness, "1/s^2")
      .def_rw("damping", &BalanceGains::damping, "1/s")
      .def_rw("touch_hz", &BalanceGains::touch_hz, "Hz, low-pass of what the skin feels")
      .def_rw("rest_hz", &BalanceGains::rest_hz, "Hz, how fast the feet tell what the skin does not feel")
      .def_rw("by_skin", &BalanceGains::by_skin, "the shift of a touch is fed forward from the skin")
      .def_rw("by_feet", &BalanceGains::by_feet, "the zero-moment point is measured");
  nb::class_<BalanceTask, Task>(module, "BalanceTask", "Moves the centre of mass so that the robot stands.")
      .def(nb::init<const RobotModel&, BalanceGains>(), "robot"_a, "gains"_a = BalanceGains{})
      .def_prop_ro("wanted", &BalanceTask::wanted, "(2) m, of the centre of mass")
      .def_prop_ro("shift", &BalanceTask::shift, "(2) m, of the point of balance by touch")
      .def_prop_ro("skin_shift", &BalanceTask::skin_shift, "(2) m, what the skin feels of it")
      .def_prop_ro("pressed", &BalanceTask::pressed, "(2) m, where the floor's force is to act");
}

void bind_model_tasks(nb::module_& module) {
  using control::CartesianGains;
  using control::CartesianTask;
  using control::GravityTask;
  using control::JointImpedanceTask;
  using control::JointLimitGains;
  using control::JointLimitTask;
  using control::JointTask;
  using control::SplineCartesianTask;
  using control::SplineJointTask;
  nb::class_<GravityTask, Task>(module, "GravityTask",
                                "The torque that holds the robot still; stands outside of levels.")
      .def(nb::init<std::size_t>(), "joint_count"_a);
  nb::class_<JointTask, Task>(module, "JointTask", "K (reference - q) - D v; as a posture, on the lowest level.")
      .def(
          "__init__",
          [](JointTask* self, const RobotModel& robot, control::JointGains gains, std::string name) {
            new (self) JointTask(robot, std::move(gains), std::move(name));
          },
          "robot"_a, "gains"_a, "name"_a = "joint")
      .def(
          "request_reference", [](JointTask& self, Doubles goal) { self.request_reference(span_of(goal)); },
          "reference"_a, "(n) rad inside the limits, else ControlError.")
      .def("request_gains", &JointTask::request_gains, "gains"_a, "The gains in use move to these.")
      .def_prop_ro(
          "reference", [](const JointTask& self) { return copy_of(self.reference()); }, nb::rv_policy::move, "(n) rad");
  nb::class_<SplineJointTask, JointTask>(module, "SplineJointTask", "A joint task whose reference moves by a quintic.")
      .def(nb::init<const RobotModel&, control::JointGains, double>(), "robot"_a, "gains"_a, "speed"_a,
           "speed in rad/s, of the fastest joint.")
      .def_prop_ro("arrived", &SplineJointTask::arrived, "the reference is at its goal");
  nb::class_<JointImpedanceTask, Task>(module, "JointImpedanceTask",
                                       "Springs and dampers towards a moving reference, on joints that keep their own "
                                       "inertia.")
      .def(nb::init<const RobotModel&, control::JointGains>(), "robot"_a, "gains"_a)
      .def(
          "request_reference",
          [](JointImpedanceTask& self, Doubles position, Doubles velocity) {
            self.request_reference(span_of(position), span_of(velocity));
          },
          "position"_a, "velocity"_a,
          "(n) rad inside the limits and (n) rad/s, else ControlError. The reference goes on so for 20 ms.")
      .def_prop_ro(
          "reference", [](const JointImpedanceTask& self) { return copy_of(self.reference()); }, nb::rv_policy::move,
          "(n) rad");
  nb::class_<CartesianGains>(module, "CartesianGains", "Impedance along and about x, y, z of the base.")
      .def(
          "__init__",
          [](CartesianGains* self, const std::vector<double>& stiffness, const std::vector<double>& damping) {
            new (self) CartesianGains{six_of(stiffness, "stiffness"), six_of(damping, "damping")};
          },
          "stiffness"_a, "damping"_a, "N/m and Nm/rad, N s/m and Nm s/rad; axes with neither are left free.")
      .def_rw("stiffness", &CartesianGains::stiffness, "(6) N/m, then Nm/rad")
      .def_rw("damping", &CartesianGains::damping, "(6) N s/m, then Nm s/rad");
  nb::class_<CartesianTask, Task>(module, "CartesianTask", "An impedance of a link's frame about a pose.")
      .def(
          "__init__",
          [](CartesianTask* self, const RobotModel& robot, const std::string& link, CartesianGains gains,
             std::string name) { new (self) CartesianTask(robot, link, gains, std::move(name)); },
          "robot"_a, "link"_a, "gains"_a, "name"_a = "Cartesian")
      .def(
          "request_reference",
          [](CartesianTask& self, Rows pose) {
            require(pose.shape(0) == 4 && pose.shape(1) == 4, "a pose is (4, 4)");
            self.request_reference({pose.data(), 16});
          },
          "base_from_link"_a, "(4, 4), metres.")
      .def_prop_ro(
          "reference", [](const CartesianTask& self) { return copy_of(self.reference(), {4, 4}); }, nb::rv_policy::move,
          "(4, 4) metres, base_from_link")
      .def_prop_ro(
          "error", [](const CartesianTask& self) { return copy_of(self.error()); }, nb::rv_policy::move,
          "(6) m and rad of the last tick");
  nb::class_<SplineCartesianTask, CartesianTask>(module, "SplineCartesianTask",
                                                 "A Cartesian task whose reference moves along a line by a quintic.")
      .def(nb::init<const RobotModel&, const std::string&, CartesianGains, double, double>(), "robot"_a, "link"_a,
           "gains"_a, "speed"_a, "turn_speed"_a, "speeds in m/s and rad/s.")
      .def_prop_ro("arrived", &SplineCartesianTask::arrived, "the reference is at its goal");
  nb::class_<JointLimitGains>(module, "JointLimitGains", "Of a JointLimitTask.")
      .def(nb::init<>())
      .def_rw("margin_rad", &JointLimitGains::margin_rad, "rad or m from a limit, where the task begins to push")
      .def_rw("stiffness", &JointLimitGains::stiffness, "Nm/rad")
      .def_rw("damping", &JointLimitGains::damping, "Nm s/rad");
  nb::class_<JointLimitTask, Task>(module, "JointLimitTask", "Pushes joints back that come near a position limit.")
      .def(nb::init<const RobotModel&, JointLimitGains>(), "robot"_a, "gains"_a = JointLimitGains{});
}

void bind_self_collision(nb::module_& module) {
  using control::SelfCollisionGains;
  using control::SelfCollisionTask;
  nb::class_<SelfCollisionGains>(module, "SelfCollisionGains", "Of a SelfCollisionTask.")
      .def(nb::init<>())
      .def_rw("safe_m", &SelfCollisionGains::safe_m, "the distance at which the task begins to act")
      .def_rw("stiffness", &SelfCollisionGains::stiffness, "N/m")
      .def_rw("damping", &SelfCollisionGains::damping, "N s/m");
  nb::class_<NearPair>(module, "NearPair", "Two bodies that are near each other, in the base frame.")
      .def_ro("pair", &NearPair::pair, "index into the pairs asked for")
      .def_ro("joint_a", &NearPair::joint_a, "that carries the first body; -1: the base")
      .def_ro("joint_b", &NearPair::joint_b, "that carries the second body; -1: the base")
      .def_ro("distance_m", &NearPair::distance_m, "m, below 0 where they overlap")
      .def_ro("point_a", &NearPair::point_a, "(3) m, of the first body, nearest to the second")
      .def_ro("point_b", &NearPair::point_b, "(3) m, of the second body, nearest to the first")
      .def_ro("a_to_b", &NearPair::a_to_b, "(3) unit vector");
  nb::class_<SelfCollisionTask, Task>(module, "SelfCollisionTask",
                                      "Pushes bodies apart that come nearer to each other than a safe distance.")
      .def(
          "__init__",
          [](SelfCollisionTask* self, const RobotModel& robot, const std::vector<std::pair<int, Rows>>& hulls,
             std::vector<std::pair<std::size_t, std::size_t>> pairs, SelfCollisionGains gains) {
            std::vector<BodyHull> bodies;
            for (const auto& [joint, points] : hulls) {
              require(points.shape(1) == 3, "the points of a hull are (m, 3)");
              bodies.push_back({joint, {points.data(), points.data() + points.size()}});
            }
            new (self) SelfCollisionTask(robot, SelfDistance(robot, bodies, std::move(pairs)), gains);
          },
          "robot"_a, "hulls"_a, "pairs"_a, "gains"_a = SelfCollisionGains{},
          "hulls: [(joint or -1, points (m, 3) metres in its frame)]; pairs: which of them must not meet. Raises "
          "ModelError for hulls and pairs that are none.")
      .def_prop_ro(
          "near",
          [](const SelfCollisionTask& self) { return std::vector<NearPair>(self.near().begin(), self.near().end()); },
          "pairs nearer than the safe distance in the last tick")
      .def_prop_ro("measured", &SelfCollisionTask::measured, "pairs whose distance the last tick measured exactly");
}

void bind_skin_tasks(nb::module_& module) {
  using control::ContactImpedanceGains;
  using control::ContactImpedanceTask;
  using control::MapSkinTask;
  using control::SkinCartesianTask;
  using control::SkinGains;
  using control::SkinReactionTask;
  using control::TouchWrench;
  nb::class_<SkinReactionTask, Task>(module, "SkinReactionTask",
                                     "The touch moves what it touches [Cheng19 eq. 14 to 17].")
      .def(nb::init<std::shared_ptr<TouchWrench>, double, double, double>(), "touch"_a, "bandwidth_hz"_a = 0.0,
           "period_s"_a = 0.001, "own_scale"_a = 1.0,
           "own_scale: the gains of the touch over those that the cells have been told.")
      .def_prop_ro(
          "host_torque", [](const SkinReactionTask& self) { return copy_of(self.host_torque()); }, nb::rv_policy::move,
          "(n) Nm, the host's sum, used or not")
      .def_prop_ro(
          "used_torque", [](const SkinReactionTask& self) { return copy_of(self.used_torque()); }, nb::rv_policy::move,
          "(n) Nm of the source in use, before the filter")
      .def_prop_ro("source_share", &SkinReactionTask::source_share, "1: all of the torque is the skin's own")
      .def_prop_ro(
          "magnitudes", [](const SkinReactionTask& self) { return copy_of(self.magnitudes()); }, nb::rv_policy::move,
          "(N) newton, float32");
  nb::class_<SkinCartesianTask, Task>(module, "SkinCartesianTask",
                                      "Every touch of the limb moves the frame of one of its links.")
      .def(nb::init<const RobotModel&, std::shared_ptr<TouchWrench>, const std::string&, double, double>(), "robot"_a,
           "touch"_a, "link"_a, "bandwidth_hz"_a = 0.0, "period_s"_a = 0.001)
      .def_prop_ro(
          "force", [](const SkinCartesianTask& self) { return copy_of(std::span<const double>(self.force())); },
          nb::rv_policy::move, "(3) newton, base frame");
  nb::class_<ContactImpedanceGains>(module, "ContactImpedanceGains", "W = inertia x'' + damping x' + stiffness x (26).")
      .def(
          "__init__",
          [](ContactImpedanceGains* self, double inertia, double damping, double stiffness) {
            new (self) ContactImpedanceGains{inertia, damping, stiffness};
          },
          "inertia"_a = 2.5, "damping"_a = 14.0, "stiffness"_a = 20.0)
      .def_rw("inertia", &ContactImpedanceGains::inertia, "kg")
      .def_rw("damping", &ContactImpedanceGains::damping, "N s/m")
      .def_rw("stiffness", &ContactImpedanceGains::stiffness, "N/m");
  nb::class_<ContactImpedanceTask, Task>(module, "ContactImpedanceTask",
                                         "Where a link is touched, it moves like a mass on a spring [Cheng19 eq. 26].")
      .def(nb::init<std::shared_ptr<TouchWrench>, ContactImpedanceGains>(), "touch"_a,
           "gains"_a = ContactImpedanceGains{});
  nb::class_<MapSkinTask, Task>(module, "MapSkinTask", "Touch turned into torques by a sensory-motor map (IV-A).")
      .def(
          "__init__",
          [](MapSkinTask* self, std::size_t joints, std::size_t cells, const SkinGains& gains,
             nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu> posture,
             nb::ndarray<const double, nb::ndim<3>, nb::c_contig, nb::device::cpu> weight, double lever) {
            control::SkinMap map{{posture.data(), posture.data() + posture.size()},
                                 {weight.data(), weight.data() + weight.size()}};
            new (self) MapSkinTask(joints, cells, gains, std::move(map), lever);
          },
          "joint_count"_a, "cell_count"_a, "gains"_a, "posture"_a, "weight"_a, "lever"_a,
          "posture (T, n) rad and weight (T, N, n) of a SensoryMotorMap in the order of the skin; lever in metres.")
      .def_prop_ro("recalled", &MapSkinTask::recalled, "index of the tile in use");
}

void bind_force(nb::module_& module) {
  using control::ForceGains;
  using control::ForceTask;
  nb::class_<ForceGains>(module, "ForceGains", "Of a ForceTask.")
      .def(nb::init<>())
      .def_rw("integral", &ForceGains::integral, "1/s")
      .def_rw("damping", &ForceGains::damping, "N s/m")
      .def_rw("largest_force", &ForceGains::largest_force, "N");
  nb::class_<ForceTask, Task>(module, "ForceTask", "The limb presses with a force that its skin measures.")
      .def(nb::init<const RobotModel&, std::shared_ptr<control::TouchWrench>, const std::string&, ForceGains>(),
           "robot"_a, "felt"_a, "link"_a, "gains"_a = ForceGains{},
           "felt: the force felt, which is a touch of SkinGains.measured_force().")
      .def(
          "request_force", [](ForceTask& self, Doubles force) { self.request_force(span_of(force)); }, "force"_a,
          "(3) newton, base frame.")
      .def_prop_ro(
          "measured", [](const ForceTask& self) { return copy_of(std::span<const double>(self.measured())); },
          nb::rv_policy::move, "(3) newton, base frame: how the cells say that the limb presses");
}

}  // namespace

void bind_control_tasks(nb::module_& module) {
  bind_task(module);
  bind_standing_tasks(module);
  bind_model_tasks(module);
  bind_self_collision(module);
  bind_skin_tasks(module);
  bind_force(module);
}

}  // namespace robotskin::bindings
