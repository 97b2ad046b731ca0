// SPDX-License-Identifier: Apache-2.0
// The stack in use, and how another takes its place while the robot runs: without lock, allocation or torque jump.
#pragma once

#include <atomic>
#include <memory>
#include <span>
#include <vector>

#include "control/task_stack.hpp"

namespace robotskin::control {

// A new stack's torque differs from that of the old one by some offset; the offset is kept at first and then fades
// along a smoothstep. So on a frozen state the torque does not change at the switch, and afterwards by at most 1.5
// |offset| dt / fade_s a tick. A stack within limits keeps these: there the torque steps by what they forbid.
class StackSwitch {
 public:
  // Throws ControlError if fade_s is not positive and finite.
  explicit StackSwitch(std::unique_ptr<TaskStack> first, double fade_s = 0.25);
  ~StackSwitch();
  StackSwitch(const StackSwitch&) = delete;
  StackSwitch& operator=(const StackSwitch&) = delete;

  // From any one thread: the stack to use from the next tick on. Tasks it shares with the one before go on as they are.
  // Throws ControlError for one of another joint count.
  void request(std::unique_ptr<TaskStack> next);

  // fused (n) Nm; see TaskStack::compute.
  [[nodiscard]] bool compute(const TaskInput& input, std::span<const double> mass, std::span<const double> bias,
                             std::span<double> fused) noexcept;
  // While the robot holds still: begin where it is, with nothing to fade.
  void restart(const TaskInput& input) noexcept;

  const TaskStack& stack() const noexcept { return *current_; }  // the tick's thread only

 private:
  bool change(const TaskInput& input) noexcept;

  TaskStack* current_;
  std::atomic<TaskStack*> next_{nullptr}, used_{nullptr};  // to the tick, and back from it to be deleted
  double fade_s_;
  double faded_s_;  // since the last switch
  std::size_t claimed_ = 0;
  bool running_ = false;                   // last_ is of the tick before
  std::vector<double> last_;               // (n) Nm
  std::vector<double> offset_, addition_;  // (n) Nm
};

}  // namespace robotskin::control
