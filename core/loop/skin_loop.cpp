// SPDX-License-Identifier: Apache-2.0
#include "loop/skin_loop.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "loop/loop_error.hpp"

namespace robotskin::loop {

SkinLoop::SkinLoop(RobotPort& port, skin::SkinInput& input, robot::TaskCycle& cycle)
    : port_(port), input_(input), cycle_(cycle) {
  if (port.joint_count() != cycle.joint_count())
    throw LoopError("loop: the robot port has " + std::to_string(port.joint_count()) + " joints, the cycle " +
                    std::to_string(cycle.joint_count()));
  if (input.cell_count() != cycle.cell_count())
    throw LoopError("loop: the skin input has " + std::to_string(input.cell_count()) + " cells, the cycle " +
                    std::to_string(cycle.cell_count()));
  skin_.resize(cycle.cell_count(), input.sensors());
  joints_ = JointState(cycle.joint_count());
  sensors_ = SensorReadings(port.sensors());
  cycle_.use_sensors(port.sensors());
  cycle_.leave_stops_to_port(port.smooths_positions());
  command_ = JointCommand(CommandMode::position, cycle.joint_count());
}

void SkinLoop::require_offered(CommandMode mode) const {
  if (port_.offers(mode)) return;
  std::string offered;
  for (const auto& [one, name] :
       {std::pair{CommandMode::position, "position"}, std::pair{CommandMode::velocity, "velocity"},
        std::pair{CommandMode::torque, "torque"}})
    if (port_.offers(one)) offered += (offered.empty() ? "" : ", ") + std::string(name);
  throw LoopError("loop: the robot port does not offer this interface; it offers " +
                  (offered.empty() ? std::string("none") : offered));
}

void SkinLoop::request_mode(CommandMode mode) {
  require_offered(mode);
  cycle_.request_mode(mode);
}

void SkinLoop::request_modes(std::span<const CommandMode> modes) {
  for (const CommandMode mode : modes) require_offered(mode);
  if (!port_.offers_by_joint() && std::ranges::any_of(modes, [&](CommandMode mode) { return mode != modes.front(); }))
    throw LoopError("loop: the robot port takes all joints through one interface");
  if (!cycle_.request_mode(modes))
    throw LoopError("loop: " + std::to_string(modes.size()) + " interfaces for " +
                    std::to_string(cycle_.joint_count()) + " joints");
}

const LoopReport& SkinLoop::step(std::int64_t now_ns) noexcept {
  ++report_.ticks;

  // Skin: samples to skin state.
  report_.input = input_.read(now_ns, skin_);
  // SAFETY: no input's word is enough: what is old, from the future or no number is not alive.
  skin::distrust(now_ns, input_.fresh_ns(), skin_);

  // Robot: joints, and what else it measures.
  report_.read = port_.read(joints_);
  report_.sensors = port_.read_sensors(sensors_);
  cycle_.estimate(sensors_, now_ns, joints_);
  input_.tell_joints(now_ns, joints_.position);

  // Control: tasks, fusion, resolver; its guard has the last word on the command.
  const robot::GuardReport& guard = cycle_.step(joints_, skin_, now_ns, command_, input_.skin_computed_torque());

  // Command or stop.
  report_.offline = report_.read == PortStatus::disconnected;
  report_.write = PortStatus::no_new_state;
  if (guard.send && !report_.offline) {
    report_.write = port_.write(command_);
    report_.offline = report_.write != PortStatus::ok;
    if (!report_.offline) ++report_.sent;
  } else if (guard.stop_port && !report_.offline) {
    port_.stop();
  }

  // SAFETY: a robot that does not answer or does not take its command is out of control. It is told to stop each tick,
  // whether it hears that or not, and when it comes back it stands until a person asks it to run anew.
  if (report_.offline) {
    ++report_.lost;
    port_.stop();
    report_.latched = report_.latched || cycle_.run_requested();
    cycle_.request_run(false);
  } else if (cycle_.run_requested()) {
    report_.latched = false;
  }
  if (witness_ != nullptr) witness_->ticked(now_ns, *this);
  return report_;
}

}  // namespace robotskin::loop
