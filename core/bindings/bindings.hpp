// SPDX-License-Identifier: Apache-2.0
// What each stage offers to Python; module.cpp calls these in the order of the flow.
#pragma once

#include <nanobind/nanobind.h>

namespace robotskin::bindings {

void bind_model(nanobind::module_ module);
void bind_shared_mailbox(nanobind::module_& module);
void bind_firmware(nanobind::module_ module);
void bind_driver(nanobind::module_ module);
void bind_skin(nanobind::module_ module);
void bind_skin_input(nanobind::module_& module);
void bind_record(nanobind::module_ module);
void bind_health(nanobind::module_ module);
void bind_control(nanobind::module_ module);
void bind_control_tasks(nanobind::module_& module);
void bind_control_fusion(nanobind::module_& module);
void bind_control_propagation(nanobind::module_& module);
void bind_robot(nanobind::module_ module);
void bind_task_cycle(nanobind::module_& module);
void bind_loop(nanobind::module_ module);
void bind_ur(nanobind::module_ module);
void bind_serial(nanobind::module_ module);
void bind_world(nanobind::module_ module);

// A part of the core, whose classes and functions say that they are of `home`, the Python module that shows them.
inline nanobind::module_ part(nanobind::module_& module, const char* name, const char* home, const char* doc) {
  nanobind::module_ made = module.def_submodule(name, doc);
  made.attr("__name__") = home;
  return made;
}

// A robotskin.errors.RobotskinError of this name, which the exception `Error` becomes in Python.
template <typename Error>
void error_class(nanobind::module_& module, const char* name, const char* doc) {
  nanobind::exception<Error>(module, name, nanobind::module_::import_("robotskin.errors").attr("RobotskinError"))
      .attr("__doc__") = doc;
}

inline void bind_all(nanobind::module_& module) {
  bind_model(
      part(module, "model", "robotskin.model", "Stage 0: the robot's kinematics and dynamics, states, commands."));
  bind_firmware(
      part(module, "firmware", "robotskin.firmware", "Stages 1 to 3: wire format, firmware of cell and unit."));
  bind_driver(part(module, "driver", "robotskin.driver", "Stage 4: datagrams to checked samples."));
  bind_skin(part(module, "skin", "robotskin.skin", "Stage 5: the skin model and the skin state."));
  bind_record(part(module, "record", "robotskin.record.tape", "What happened on the way from datagram to state."));
  bind_health(part(module, "health", "robotskin.health.windows", "Evidence of the health of cells."));
  bind_control(part(module, "control", "robotskin.tasks", "Stage 7: tasks, fusion and the torque resolver."));
  bind_robot(part(module, "robot", "robotskin.cycle", "Stage 8: limits, watchdog, last check before the robot."));
  bind_loop(part(module, "loop", "robotskin.loop", "The loop that runs on a robot, from samples to command."));
  bind_ur(part(module, "ur", "robotskin.ur", "The port of a UR robot, and the script that runs on its controller."));
  bind_serial(
      part(module, "serial", "robotskin.serial_lines", "Section unit and cells on serial lines of this machine."));
  bind_world(part(module, "world", "robotskin.simulator", "The simulated two ends: links and the robot's body."));
}

}  // namespace robotskin::bindings
