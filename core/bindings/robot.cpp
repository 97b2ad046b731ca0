// SPDX-License-Identifier: Apache-2.0
// Binds the robot stage.
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings/arrays.hpp"
#include "bindings/bindings.hpp"
#include "robot/guard.hpp"
#include "robot/safety_table.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::robot {
namespace {

void bind_table(nb::module_& module) {
  nb::enum_<SafetyState>(module, "SafetyState", "The states a controlled robot can be in.")
      .value("off", SafetyState::off)
      .value("ready", SafetyState::ready)
      .value("running", SafetyState::running)
      .value("degraded", SafetyState::degraded)
      .value("stopped", SafetyState::stopped);
  nb::enum_<Reason>(module, "Reason", "Why a safety state was entered.")
      .value("none", Reason::none)
      .value("joints_stale", Reason::joints_stale)
      .value("joints_beyond", Reason::joints_beyond)
      .value("skin_lost", Reason::skin_lost)
      .value("skin_partly_lost", Reason::skin_partly_lost)
      .value("command_not_finite", Reason::command_not_finite)
      .value("overrun", Reason::overrun)
      .value("asked", Reason::asked)
      .value("body_limit", Reason::body_limit)
      .value("unbalanced", Reason::unbalanced);
  nb::enum_<Condition>(module, "Condition", nb::is_flag(), "What is checked every cycle, one bit each.")
      .value("joints_fresh", joints_fresh)
      .value("joints_inside", joints_inside)
      .value("skin_fresh", skin_fresh)
      .value("skin_whole", skin_whole)
      .value("command_finite", command_finite)
      .value("on_time", on_time)
      .value("wanted", wanted)
      .value("at_rest", at_rest)
      .value("contact_within", contact_within)
      .value("balanced", balanced);
  module.def(
      "next_transition",
      [](SafetyState state, std::uint16_t conditions) -> nb::object {
        const Transition* row = next_transition(state, conditions);
        if (row == nullptr) return nb::none();
        return nb::make_tuple(row->to, row->reason);
      },
      "state"_a, "conditions"_a, "(state, reason) that follow in the safety table, None if the state stays.");
  module.def(
      "safety_table",
      [] {
        nb::list rows;
        for (const Transition& row : safety_table)
          rows.append(nb::make_tuple(row.from, row.all_of, row.none_of, row.to, row.reason));
        return rows;
      },
      "[(state, bits of Condition that must hold, bits that must not, state that follows, reason)]: the first row that "
      "fits is taken.");
  module.def("reason_text", [](Reason reason) { return name(reason); }, "reason"_a, "The reason in words.");
}

void bind_body_limits(nb::module_& module) {
  nb::class_<ContactLimit>(module, "ContactLimit", "Of force in N or pressure in N/cm^2; inf: none is given.")
      .def(
          "__init__",
          [](ContactLimit* self, double transient, double quasi_static) {
            new (self) ContactLimit{transient, quasi_static};
          },
          "transient"_a = ContactLimit{}.transient, "quasi_static"_a = ContactLimit{}.quasi_static)
      .def_ro("transient", &ContactLimit::transient, "N or N/cm^2, of a short contact; infinite: none")
      .def_ro("quasi_static", &ContactLimit::quasi_static, "N or N/cm^2, of a lasting contact; infinite: none");
  nb::class_<BodyRegion>(module, "BodyRegion", "A region of a person's body and the cells that may meet it.")
      .def(
          "__init__",
          [](BodyRegion* self, std::string region, std::vector<std::size_t> cells, ContactLimit force,
             ContactLimit pressure, double transient_s) {
            new (self) BodyRegion{std::move(region), std::move(cells), force, pressure, transient_s};
          },
          "name"_a, "cells"_a, "force"_a = ContactLimit{}, "pressure"_a = ContactLimit{}, "transient_s"_a = 0.0)
      .def_ro("name", &BodyRegion::name, "of the region")
      .def_ro("cells", &BodyRegion::cells, "indices of its cells")
      .def_ro("force", &BodyRegion::force, "N, on all of the region")
      .def_ro("pressure", &BodyRegion::pressure, "N/cm^2, of a cell's force over its hexagon")
      .def_ro("transient_s", &BodyRegion::transient_s, "for which a contact is transient");
  nb::class_<BodyLimits>(module, "BodyLimits", "Limits of the contact with a person, region by region.")
      .def(
          "__init__",
          [](BodyLimits* self, std::vector<BodyRegion> regions, double silent_n) {
            new (self) BodyLimits{std::move(regions), silent_n};
          },
          "regions"_a, "silent_n"_a, "silent_n: a cell that feels no more is not touched.")
      .def_ro("regions", &BodyLimits::regions, "BodyRegion of each");
  module.def("cell_area_cm2", &cell_area_cm2, "Over which a cell's force is a pressure.");
}

void bind_guard(nb::module_& module) {
  bindings::error_class<GuardError>(module, "GuardError", "Limits that do not fit the robot or the skin.");
  nb::class_<GuardLimits>(module, "GuardLimits", "Limits beside those of the robot model.")
      .def(
          "__init__",
          [](GuardLimits* self, std::vector<double> acceleration, std::vector<double> stop_deceleration,
             std::vector<double> torque_rate) {
            new (self) GuardLimits{std::move(acceleration), std::move(stop_deceleration), std::move(torque_rate)};
          },
          "acceleration"_a, "stop_deceleration"_a, "torque_rate"_a)
      .def_rw("acceleration", &GuardLimits::acceleration, "(n) rad/s^2, of commands")
      .def_rw("stop_deceleration", &GuardLimits::stop_deceleration, "(n) rad/s^2, of a controlled stop")
      .def_rw("torque_rate", &GuardLimits::torque_rate, "(n) Nm/s")
      .def_rw("position_margin", &GuardLimits::position_margin,
              "rad (m) kept from the position limits, at most 5 % of the room between them")
      .def_rw(
          "end_tolerance", &GuardLimits::end_tolerance,
          "rad (m) by which a joint may be measured beyond a position limit, at most 0.5 % of the room between them")
      .def_rw("speed_share", &GuardLimits::speed_share, "share of the velocity limits commands may use")
      .def_rw("degraded_speed_share", &GuardLimits::degraded_speed_share, "the same while degraded")
      .def_rw("rest_speed", &GuardLimits::rest_speed, "rad/s")
      .def_rw("smallest_alive_share", &GuardLimits::smallest_alive_share, "of the cells, below it the skin is lost")
      .def_rw("whole_alive_share", &GuardLimits::whole_alive_share, "of the cells, below it the robot is slow")
      .def_rw("joints_timeout_ns", &GuardLimits::joints_timeout_ns, "age from which joint states are stale")
      .def_rw("skin_timeout_ns", &GuardLimits::skin_timeout_ns, "age from which the skin is stale")
      .def_rw("largest_cycle_ns", &GuardLimits::largest_cycle_ns, "time between two cycles, beyond it the robot stops")
      .def_rw("period_s", &GuardLimits::period_s, "s, of a cycle")
      .def_rw("body", &GuardLimits::body, "limits of contact, by body region");
  nb::enum_<Limit>(module, "Limit", "Which limit made the guard change a command.")
      .value("position", Limit::position)
      .value("velocity", Limit::velocity)
      .value("acceleration", Limit::acceleration)
      .value("torque", Limit::torque)
      .value("torque_rate", Limit::torque_rate);
  nb::class_<GuardReport>(module, "GuardReport", "What the guard decided in the last cycle.")
      .def_ro("state", &GuardReport::state, "SafetyState")
      .def_ro("reason", &GuardReport::reason, "Reason for which the state was entered")
      .def_ro("conditions", &GuardReport::conditions, "bits of Condition")
      .def_ro("send", &GuardReport::send, "the command may go to the robot")
      .def_ro("stop_port", &GuardReport::stop_port, "call RobotPort.stop: the robot cannot be controlled from here")
      .def_ro("interventions", &GuardReport::interventions, "cycles in which the guard changed a running command")
      .def_ro("limit", &GuardReport::limit, "that the last intervention kept")
      .def_ro("limited_joint", &GuardReport::limited_joint, "of which joint; -1: there was no intervention")
      .def_ro("violations", &GuardReport::violations,
              "joint states measured beyond position, velocity or torque limits")
      .def_ro("alive_share", &GuardReport::alive_share, "of the cells")
      .def_prop_ro(
          "text",
          [](const GuardReport& self) {
            return self.reason == Reason::body_limit ? text_of(self.excess) : std::string(name(self.reason));
          },
          "the reason in words, with the values where there are any");
  nb::class_<Guard>(module, "Guard", "The last word before the robot.")
      .def(nb::init<const RobotModel&, GuardLimits>(), "robot"_a, "limits"_a)
      .def(
          "check",
          [](Guard& self, const RobotDynamics& dynamics, const JointState& joints, const skin::SkinState& skin,
             std::int64_t now_ns, bool run_wanted, bool finite,
             JointCommand& command) { return self.check(dynamics, joints, skin, now_ns, run_wanted, finite, command); },
          "dynamics"_a, "joints"_a, "skin"_a, "now_ns"_a, "run_wanted"_a, "finite"_a, "command"_a,
          "Rewrites the command where it has to; returns the report.")
      .def_prop_ro("report", &Guard::report, nb::rv_policy::copy, "GuardReport of the last check");
}

}  // namespace
}  // namespace robotskin::robot

namespace robotskin::bindings {

void bind_robot(nb::module_ module) {
  robot::bind_table(module);
  robot::bind_body_limits(module);
  robot::bind_guard(module);
  bind_task_cycle(module);
}

}  // namespace robotskin::bindings
