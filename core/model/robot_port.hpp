// SPDX-License-Identifier: Apache-2.0
// The one interface through which anything moves a robot, simulated or real.
#pragma once

#include <cstddef>
#include <cstdint>
#include <ctime>

#include "model/joint_command.hpp"
#include "model/joint_state.hpp"
#include "model/sensor_readings.hpp"

namespace robotskin {

enum class PortStatus : std::uint8_t {
  ok,
  no_new_state,  // read: nothing measured since the last read; the state passed in is left as it was
  refused,       // write: mode not offered, wrong count or a value that is not finite; the robot got nothing
  disconnected,  // the robot does not answer
};

// How long a command is good for. The commanding program may have died: a port that hears nothing for longer stops.
inline constexpr double command_life_s = 0.02;

// Called from the control cycle: no function blocks, allocates or throws. After construction the robot holds still
// until the first accepted write.
class RobotPort {
 public:
  virtual ~RobotPort() = default;

  virtual std::size_t joint_count() const noexcept = 0;
  virtual bool offers(CommandMode mode) const noexcept = 0;
  // Whether each joint may be commanded through an interface of its own, of those that are offered.
  virtual bool offers_by_joint() const noexcept { return false; }
  // Whether the robot smooths the positions that it is given, so that `stop` brings it to rest sooner than they can.
  virtual bool smooths_positions() const noexcept { return false; }

  // What the robot measures beside its joints; asked once, before the first read, so it may allocate and throw.
  virtual PortSensors sensors() const { return {}; }

  // Fills a state of joint_count() joints, which the caller has sized; its stamp tells when it was measured.
  [[nodiscard]] virtual PortStatus read(JointState& state) noexcept = 0;
  // Fills what is new in readings made for sensors(); a sensor that has not measured anything is left as it was.
  [[nodiscard]] virtual PortStatus read_sensors(SensorReadings&) noexcept { return PortStatus::no_new_state; }
  // Holds until the next write or stop, at most for command_life_s; then the robot is stopped.
  [[nodiscard]] virtual PortStatus write(const JointCommand& command) noexcept = 0;
  // Brings the robot to rest and keeps it there against gravity, whatever was commanded before.
  virtual void stop() noexcept = 0;

  // Between two states, where `await_state` tells each as it comes; 0: it cannot tell.
  virtual double period_s() const noexcept { return 0; }
  // Outside of the cycle: waits until there may be a new state to read, at longest until the host's clock shows
  // `until_ns`. A port that cannot tell waits until then.
  virtual void await_state(std::int64_t until_ns) noexcept {
    const timespec until{until_ns / 1'000'000'000, until_ns % 1'000'000'000};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
  }
};

}  // namespace robotskin
