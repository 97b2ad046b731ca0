// SPDX-License-Identifier: Apache-2.0
// What each stage offers to Python; module.cpp calls these in the order of the flow.
#pragma once

#include <nanobind/nanobind.h>

namespace robotskin::bindings {

void bind_model(nanobind::module_ module);
void bind_firmware(nanobind::module_ module);
void bind_driver(nanobind::module_ module);
void bind_skin(nanobind::module_ module);
void bind_skin_input(nanobind::module_& module);
void bind_record(nanobind::module_ module);
void bind_control(nanobind::module_ module);
void bind_control_tasks(nanobind::module_& module);
void bind_control_fusion(nanobind::module_& module);
void bind_robot(nanobind::module_ module);
void bind_task_cycle(nanobind::module_& module);
void bind_loop(nanobind::module_ module);
void bind_world(nanobind::module_ module);

inline void bind_all(nanobind::module_& module) {
  bind_model(module.def_submodule("model", "Stage 0: the robot's kinematics and dynamics, states and commands."));
  bind_firmware(module.def_submodule("firmware", "Stages 1 to 3: wire format and firmware of cell and section unit."));
  bind_driver(module.def_submodule("driver", "Stage 4: datagrams to checked samples."));
  bind_skin(module.def_submodule("skin", "Stage 5: the skin model and the skin state."));
  bind_record(module.def_submodule("record", "Recording and replay: what happened on the way from datagram to state."));
  bind_control(module.def_submodule("control", "Stage 7: tasks, fusion and the torque resolver."));
  bind_robot(module.def_submodule("robot", "Stage 8: limits, watchdog and the last check before the robot."));
  bind_loop(module.def_submodule("loop", "The loop that runs on a robot, from samples to command."));
  bind_world(module.def_submodule("world", "The simulated two ends: links between cells, and the robot's body."));
}

}  // namespace robotskin::bindings
