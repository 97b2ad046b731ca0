// SPDX-License-Identifier: Apache-2.0
// Binds the port of a UR robot.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include "bindings/bindings.hpp"
#include "ur/ur_error.hpp"
#include "ur/ur_port.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::bindings {

using ur::ScriptSettings;
using ur::UrCondition;
using ur::UrError;
using ur::UrFacts;
using ur::UrPort;

void bind_ur(nb::module_ module) {
  error_class<UrError>(module, "UrError",
                       "A controller that is not there, is another one, or cannot do what is needed.");
  module.attr("DASHBOARD_PORT") = ur::dashboard_port;
  module.attr("SCRIPT_PORT") = ur::script_port;
  module.attr("RTDE_PORT") = ur::rtde_port;

  nb::enum_<UrCondition>(module, "UrCondition", "Why a UR robot takes commands, or does not.")
      .value("ready", UrCondition::ready)
      .value("disconnected", UrCondition::disconnected)
      .value("starting", UrCondition::starting)
      .value("protective_stop", UrCondition::protective_stop)
      .value("safeguard_stop", UrCondition::safeguard_stop)
      .value("emergency_stop", UrCondition::emergency_stop)
      .value("fault", UrCondition::fault)
      .value("not_running", UrCondition::not_running);
  module.def("told", &ur::text_of, "condition"_a, "The condition in words that say what to do.");
  module.def(
      "script",
      [](double step_s, int life_cycles, bool takes_torque, std::int32_t program) {
        return ur::script_text({.step_s = step_s, .life_cycles = life_cycles, .takes_torque = takes_torque}, program);
      },
      "step_s"_a = 0.002, "life_cycles"_a = 10, "takes_torque"_a = true, "program"_a = 1,
      "The program (URScript) that runs on the controller. `life_cycles`: steps without a new command, after which it "
      "stops the robot. `program`: its number.");

  nb::class_<UrFacts>(module, "UrFacts", "What a controller says of itself before anything moves.")
      .def_ro("model", &UrFacts::model, "as its dashboard says, such as UR5")
      .def_prop_ro("version", &UrFacts::version_text, "of the controller's software")
      .def_ro("remote_control", &UrFacts::remote_control, "None: a controller that does not know the question")
      .def_ro("step_s", &UrFacts::step_s, "between two states")
      .def_prop_ro("takes_torque", &UrFacts::takes_torque, "whether it knows direct_torque");

  nb::class_<UrPort, RobotPort>(module, "UrPort",
                                R"(A UR robot (CB 3.9, e-series 5.3 or newer) behind the port of any robot.

A thread of the port speaks RTDE with the controller; the control cycle never waits for it. Effort is what the
controller asks of its motors (target_moment). Positions go through servoj, velocities through speedj, torques through
direct_torque, which a controller has from 5.23 on. A script on the controller stops the robot by itself 20 ms after
the last command.)")
      .def(
          "__init__",
          [](UrPort* self, const RobotModel& model, std::string host, std::string expected, double within_s,
             double silent_s, bool realtime) {
            ur::UrOptions options{.host = std::move(host),
                                  .model = std::move(expected),
                                  .within_s = within_s,
                                  .silent_s = silent_s,
                                  .realtime = realtime};
            const nb::gil_scoped_release unlocked;
            new (self) UrPort(model, std::move(options));
          },
          "model"_a, "host"_a, "expected"_a = "", "within_s"_a = 2.0, "silent_s"_a = 0.1, "realtime"_a = false,
          R"(Connects, checks, and starts the script, which holds still.

model: of the robot, whose gravity the controller carries by itself. host: address of the controller. expected: which
robot must answer, such as "UR5"; "" for any with six joints. within_s: time for the first connection. silent_s:
without a state, after which the connection counts as gone. realtime: the thread runs before all that are not
real-time, where the system permits it.
Raises UrError with what was found and what was expected.)")
      .def(
          "close",
          [](UrPort& self) {
            const nb::gil_scoped_release unlocked;
            self.close();
          },
          "Stops the robot and ends the connection for good.")
      .def_prop_ro("facts", &UrPort::facts, nb::rv_policy::reference_internal, "what the controller said of itself")
      .def_prop_ro("condition", &UrPort::condition, "why it takes commands, or does not; `told` says it in words")
      .def_prop_ro("speed_fraction", &UrPort::speed_fraction, "of the speed slider, 0 to 1")
      .def_prop_ro("connections", &UrPort::connections, "made so far")
      .def_prop_ro("thread_seconds", &UrPort::thread_seconds, "processor time of the port's thread")
      .def_prop_ro(
          "latency",
          [](UrPort& self) {
            return nb::make_tuple(self.latency().quantile(0.5), self.latency().quantile(0.99),
                                  self.latency().quantile(1.0), self.latency().total());
          },
          nb::sig("def latency(self) -> tuple[float, float, float, int]"),
          "(median, p99, worst) seconds from the arrival of a state to its command, and of how many; 0.02 is 20 ms or "
          "more")
      .def("forget_latency", [](UrPort& self) { self.latency().clear(); }, "Counts anew.");
}

}  // namespace robotskin::bindings
