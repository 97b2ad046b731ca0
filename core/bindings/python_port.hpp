// SPDX-License-Identifier: Apache-2.0
// A robot port written in Python.
#pragma once

#include <algorithm>
#include <vector>

#include "bindings/python_part.hpp"
#include "model/robot_port.hpp"

namespace robotskin::bindings {

class PythonPort final : public RobotPort, public PythonPart {
 public:
  NB_TRAMPOLINE(RobotPort);

  PythonPort(std::size_t joint_count, std::vector<CommandMode> modes, PortSensors sensors, bool by_joint,
             bool smooths_positions)
      : joint_count_(joint_count),
        modes_(std::move(modes)),
        sensors_(std::move(sensors)),
        by_joint_(by_joint),
        smooths_positions_(smooths_positions) {}

  std::size_t joint_count() const noexcept override { return joint_count_; }
  bool offers(CommandMode mode) const noexcept override { return std::ranges::find(modes_, mode) != modes_.end(); }
  bool offers_by_joint() const noexcept override { return by_joint_; }
  bool smooths_positions() const noexcept override { return smooths_positions_; }
  PortSensors sensors() const override { return sensors_; }

  PortStatus read(JointState& state) noexcept override {
    return guarded(nb_trampoline, "read", PortStatus::disconnected,
                   [&] { return ask("read", nanobind::detail::str_hash("read"), &state); });
  }
  PortStatus write(const JointCommand& command) noexcept override {
    return guarded(nb_trampoline, "write", PortStatus::disconnected,
                   [&] { return ask("write", nanobind::detail::str_hash("write"), &command); });
  }
  PortStatus read_sensors(SensorReadings& readings) noexcept override {
    if (sensors_.imus.empty() && sensors_.forces.empty()) return PortStatus::no_new_state;
    return guarded(nb_trampoline, "read_sensors", PortStatus::disconnected,
                   [&] { return ask("read_sensors", nanobind::detail::str_hash("read_sensors"), &readings); });
  }
  void stop() noexcept override {
    (void)guarded(nb_trampoline, "stop", false, [&] {
      const nanobind::detail::ticket ticket(nb_trampoline, "stop", nanobind::detail::str_hash("stop"), true);
      nb_trampoline.base().attr(ticket.key)();
      return true;
    });
  }

 private:
  template <typename Value>
  PortStatus ask(const char* method, std::uint64_t hash, Value* value) {
    const nanobind::detail::ticket ticket(nb_trampoline, method, hash, true);
    return status_of<PortStatus>(
        nb_trampoline.base().attr(ticket.key)(nanobind::cast(value, nanobind::rv_policy::reference)),
        "PortStatus.ok, no_new_state, refused or disconnected");
  }

  std::size_t joint_count_;
  std::vector<CommandMode> modes_;
  PortSensors sensors_;
  bool by_joint_, smooths_positions_;
};

}  // namespace robotskin::bindings
