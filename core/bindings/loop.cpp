// SPDX-License-Identifier: Apache-2.0
// Binds the loop.
#include <nanobind/stl/vector.h>

#include <string>

#include "bindings/bindings.hpp"
#include "bindings/python_part.hpp"
#include "loop/loop_error.hpp"
#include "loop/paced_loop.hpp"
#include "loop/skin_loop.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::bindings {
namespace {

using loop::LoopError;
using loop::LoopReport;
using loop::PacedLoop;
using loop::SkinLoop;

// After the tick, in which the robot was stopped: what its Python parts did amiss.
void raise_error_of(SkinLoop& self) {
  for (PythonPart* part : {dynamic_cast<PythonPart*>(&self.port()), dynamic_cast<PythonPart*>(&self.input())}) {
    const std::string error = part == nullptr ? std::string() : part->take_error();
    if (!error.empty()) throw LoopError(error);
  }
}

}  // namespace

void bind_loop(nb::module_ module) {
  error_class<LoopError>(module, "LoopError", "Parts of a loop that do not fit together, or one that failed.");
  nb::class_<LoopReport>(module, "LoopReport", "What became of the last tick, and of all before it.")
      .def_ro("input", &LoopReport::input, "InputStatus of the skin")
      .def_ro("read", &LoopReport::read, "PortStatus of the joints")
      .def_ro("sensors", &LoopReport::sensors, "PortStatus of what the robot measures beside its joints")
      .def_ro("write", &LoopReport::write, "PortStatus of the command; no_new_state: none was sent")
      .def_ro("offline", &LoopReport::offline, "the robot did not answer, or did not take its command")
      .def_ro("latched", &LoopReport::latched, "it was lost while it was to run: it stands until asked to run anew")
      .def_ro("ticks", &LoopReport::ticks, "so far")
      .def_ro("sent", &LoopReport::sent, "commands that the robot took")
      .def_ro("lost", &LoopReport::lost, "ticks in which it was offline");
  nb::class_<SkinLoop>(module, "SkinLoop",
                       "Samples of a skin in, commands to the robot out: the loop that runs on a robot, real or "
                       "simulated. It belongs to one thread.")
      .def(nb::init<RobotPort&, skin::SkinInput&, robot::TaskCycle&>(), "port"_a, "input"_a, "cycle"_a,
           nb::keep_alive<1, 2>(), nb::keep_alive<1, 3>(), nb::keep_alive<1, 4>(),
           "Raises LoopError, with the counts, for parts that do not fit together.")
      .def(
          "step",
          [](SkinLoop& self, std::int64_t now_ns) -> const LoopReport& {
            const LoopReport* report = nullptr;
            {
              const nb::gil_scoped_release unlocked;
              report = &self.step(now_ns);
            }
            raise_error_of(self);
            return *report;
          },
          "now_ns"_a, nb::rv_policy::reference_internal,
          "One tick at host time `now_ns`, which grows. Raises LoopError for what a port or an input written in Python "
          "raised or answered amiss; the robot was told to stop before.")
      .def("request_run", &SkinLoop::request_run, "run"_a, "To run, or to stop smoothly. Ends a latched stop.")
      .def("request_mode", &SkinLoop::request_mode, "mode"_a, "Raises LoopError for one that the port does not offer.")
      .def(
          "request_modes", [](SkinLoop& self, const std::vector<CommandMode>& modes) { self.request_modes(modes); },
          "modes"_a,
          "(n) of each joint. Raises LoopError for another number of them, and for what the port does not offer.")
      .def_prop_ro("report", &SkinLoop::report, nb::rv_policy::reference_internal, "LoopReport of the last tick")
      .def_prop_ro("guard", &SkinLoop::guard, nb::rv_policy::reference_internal, "GuardReport of the last tick")
      .def_prop_ro("skin", &SkinLoop::skin, nb::rv_policy::reference_internal, "SkinState of the last tick")
      .def_prop_ro("joints", &SkinLoop::joints, nb::rv_policy::reference_internal, "JointState of the last tick")
      .def_prop_ro("sensors", &SkinLoop::sensors, nb::rv_policy::reference_internal, "SensorReadings of the last tick")
      .def_prop_ro("command", &SkinLoop::command, nb::rv_policy::reference_internal, "JointCommand of the last tick");
  nb::class_<PacedLoop>(module, "PacedLoop", "Ticks a loop in real time: with the robot's states, or with the clock.")
      .def(nb::init<SkinLoop&, double, bool>(), "loop"_a, "period_s"_a, "realtime"_a = false, nb::keep_alive<1, 2>(),
           "period_s: of one tick, the one for which the controller was made. realtime: while it runs, its thread goes "
           "before all that are not real-time, where the system permits it.")
      .def(
          "run",
          [](PacedLoop& self, double seconds) {
            {
              const nb::gil_scoped_release unlocked;
              self.run(seconds);
            }
            raise_error_of(self.loop());
          },
          "seconds"_a, "Ticks for a time. Raises LoopError as `SkinLoop.step` does, at the end of that time.")
      .def_prop_ro("ticks", &PacedLoop::ticks, "so far")
      .def_prop_ro("late_ticks", &PacedLoop::late_ticks, "those that came more than half a period late")
      .def_prop_ro("worst_gap_s", &PacedLoop::worst_gap_s, "longest time between two ticks of one run")
      .def_prop_ro("realtime", &PacedLoop::realtime, "whether the system permitted that when it ran last")
      .def("forget", &PacedLoop::forget, "Counts anew.");
}

}  // namespace robotskin::bindings
