// SPDX-License-Identifier: Apache-2.0
// The program that runs on the controller: it takes commands out of registers, and stops the robot where none come.
#pragma once

#include <cstdint>
#include <string>

namespace robotskin::ur {

// Registers of RTDE: 24 to 47 are those for programs outside of the controller.
inline constexpr int sequence_register = 24;  // in: grows with every command; out: the last one that the script saw
inline constexpr int mode_register = 25;      // in: Mode; out: the number of the program that runs
inline constexpr int value_register = 24;     // in, first of six doubles: rad, rad/s or Nm

enum class Mode : std::uint8_t { stop, position, velocity, torque };

struct ScriptSettings {
  double step_s = 0.002;          // of the controller
  int life_cycles = 10;           // without a new command, after which the script stops the robot
  double lookahead_s = 0.03;      // of servoj, 0.03 to 0.2: smooths what is commanded
  double gain = 2000;             // of servoj, 100 to 2000
  double acceleration = 40;       // rad/s^2 with which speedj follows; the guard has limited it before
  double stop_deceleration = 10;  // rad/s^2 of stopj
  bool takes_torque = false;      // the controller knows direct_torque
};

// `program`: its number, by which the port knows its own script again.
std::string script_text(const ScriptSettings& settings, std::int32_t program);

}  // namespace robotskin::ur
