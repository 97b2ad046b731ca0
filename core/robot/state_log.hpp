// SPDX-License-Identifier: Apache-2.0
// The last second of a controlled robot, kept to tell why it stopped.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "model/joint_command.hpp"
#include "model/joint_state.hpp"
#include "robot/safety_table.hpp"

namespace robotskin::robot {

// A ring of ticks, sized once. Recording allocates nothing.
class StateLog {
 public:
  struct Tick {
    std::int64_t time_ns = never_ns;
    SafetyState state = SafetyState::off;
  };

  StateLog(std::size_t ticks, std::size_t joint_count)
      : ticks_(ticks), joints_(joint_count), modes_(ticks * joint_count), values_(ticks * width * joint_count) {}

  void record(std::int64_t now_ns, SafetyState state, const JointState& joints, std::span<const double> torque,
              const JointCommand& command) noexcept {
    ticks_[next_] = {now_ns, state};
    for (std::size_t i = 0; i < joints_ && i < command.mode.size(); ++i) modes_[next_ * joints_ + i] = command.mode[i];
    double* out = &values_[next_ * width * joints_];
    const auto put = [&](std::span<const double> values) {
      for (std::size_t i = 0; i < joints_; ++i) *out++ = i < values.size() ? values[i] : 0.0;
    };
    put(joints.position);
    put(joints.velocity);
    put(torque);
    put(command.value);
    next_ = (next_ + 1) % ticks_.size();
    if (count_ < ticks_.size()) ++count_;
  }

  std::size_t count() const noexcept { return count_; }
  std::size_t joint_count() const noexcept { return joints_; }
  // The oldest is 0.
  const Tick& tick(std::size_t index) const noexcept { return ticks_[place(index)]; }
  // (n) of its command.
  std::span<const CommandMode> modes(std::size_t index) const noexcept {
    return {&modes_[place(index) * joints_], joints_};
  }
  // (4, n) position rad, velocity rad/s, fused torque Nm, command by mode.
  std::span<const double> values(std::size_t index) const noexcept {
    return {&values_[place(index) * width * joints_], width * joints_};
  }

  static constexpr std::size_t width = 4;

 private:
  std::size_t place(std::size_t index) const noexcept {
    return (next_ + ticks_.size() - count_ + index) % ticks_.size();
  }

  std::vector<Tick> ticks_;
  std::size_t joints_;
  std::vector<CommandMode> modes_;  // (ticks, n)
  std::vector<double> values_;      // (ticks, 4, n)
  std::size_t next_ = 0, count_ = 0;
};

}  // namespace robotskin::robot
