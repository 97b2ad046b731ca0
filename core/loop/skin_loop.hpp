// SPDX-License-Identifier: Apache-2.0
// The loop that runs on a robot: samples of a skin in, commands to the robot out, once a period.
#pragma once

#include <cstdint>
#include <span>

#include "loop/loop_witness.hpp"
#include "model/robot_port.hpp"
#include "robot/task_cycle.hpp"
#include "skin/skin_input.hpp"

namespace robotskin::loop {

// What became of the last tick, and of all before it.
struct LoopReport {
  skin::InputStatus input = skin::InputStatus::nothing_new;
  PortStatus read = PortStatus::no_new_state;
  PortStatus sensors = PortStatus::no_new_state;
  PortStatus write = PortStatus::no_new_state;  // ok: the command is with the robot; no_new_state: none was sent
  bool offline = false;                         // the robot did not answer, or did not take its command
  bool latched = false;     // it was lost while it was to run: it stands until it is asked to run anew
  std::uint64_t ticks = 0;  // since the loop was made
  std::uint64_t sent = 0;   // commands that the robot took
  std::uint64_t lost = 0;   // ticks in which it was offline
};

// Simulated or real, the two ends are the same to it: a SkinInput and a RobotPort. Time is an argument. The loop
// belongs to one thread; the cycle's requests may come from others.
class SkinLoop {
 public:
  // All three are kept and must outlive the loop. Throws LoopError, naming counts, where they do not fit together.
  SkinLoop(RobotPort& port, skin::SkinInput& input, robot::TaskCycle& cycle);

  // One tick. `now_ns` is the clock of all stamps and grows. Never blocks, allocates, locks or throws, if port, input
  // and tasks do not.
  const LoopReport& step(std::int64_t now_ns) noexcept;

  // To run, or to stop smoothly. Ends a latched stop.
  void request_run(bool run) noexcept { cycle_.request_run(run); }
  // Throws LoopError for a mode that the port does not offer.
  void request_mode(CommandMode mode);
  // Of each joint (n). Throws LoopError for another number of them, and for what the port does not offer.
  void request_modes(std::span<const CommandMode> modes);

  // Lets `witness` look on from the next tick on, or none (null). It must outlive the loop. From the loop's thread.
  void set_witness(LoopWitness* witness) noexcept { witness_ = witness; }

  const LoopReport& report() const noexcept { return report_; }
  const robot::GuardReport& guard() const noexcept { return cycle_.report(); }
  const robot::FusionCounts& fusion_counts() const noexcept { return cycle_.fusion_counts(); }
  const skin::SkinState& skin() const noexcept { return skin_; }
  const JointState& joints() const noexcept { return joints_; }
  const SensorReadings& sensors() const noexcept { return sensors_; }
  const JointCommand& command() const noexcept { return command_; }
  RobotPort& port() noexcept { return port_; }
  skin::SkinInput& input() noexcept { return input_; }
  robot::TaskCycle& cycle() noexcept { return cycle_; }

 private:
  void require_offered(CommandMode mode) const;

  RobotPort& port_;
  skin::SkinInput& input_;
  robot::TaskCycle& cycle_;
  skin::SkinState skin_;
  JointState joints_;
  SensorReadings sensors_;
  JointCommand command_;
  LoopReport report_;
  LoopWitness* witness_ = nullptr;
};

}  // namespace robotskin::loop
