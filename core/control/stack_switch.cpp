// SPDX-License-Identifier: Apache-2.0
#include "control/stack_switch.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "control/control_error.hpp"

namespace robotskin::control {

StackSwitch::StackSwitch(std::unique_ptr<TaskStack> first, double fade_s)
    : current_(nullptr), fade_s_(fade_s), faded_s_(fade_s) {
  if (!first) throw ControlError("stack switch: there is no stack");
  if (!(fade_s > 0) || !std::isfinite(fade_s))
    throw ControlError("stack switch: fade " + std::to_string(fade_s) + " s must be finite and greater than 0");
  last_.resize(first->joint_count());
  offset_.resize(first->joint_count());
  addition_.resize(first->joint_count());
  current_ = first.release();
}

StackSwitch::~StackSwitch() {
  delete current_;
  delete next_.load();
  delete used_.load();
}

void StackSwitch::request(std::unique_ptr<TaskStack> next) {
  if (!next || next->joint_count() != last_.size())
    throw ControlError("stack switch: the stack is for " + std::to_string(next ? next->joint_count() : 0) +
                       " joints, the robot has " + std::to_string(last_.size()));
  delete used_.exchange(nullptr, std::memory_order_acquire);
  delete next_.exchange(next.release(), std::memory_order_acq_rel);  // one that was never used
}

bool StackSwitch::change(const TaskInput& input) noexcept {
  // The old stack waits in used_ for the next call; while one waits there, the next one has to wait, too.
  if (next_.load(std::memory_order_relaxed) == nullptr || used_.load(std::memory_order_acquire) != nullptr)
    return false;
  TaskStack* next = next_.exchange(nullptr, std::memory_order_acq_rel);
  if (next == nullptr) return false;
  next->start(input, current_);
  used_.store(current_, std::memory_order_release);
  current_ = next;
  return true;
}

bool StackSwitch::compute(const TaskInput& input, std::span<const double> mass, std::span<const double> bias,
                          std::span<double> fused) noexcept {
  const bool changed = change(input);
  if (!current_->compute(input, mass, bias, fused)) return false;
  const std::size_t claimed = current_->claimed();
  if ((changed || claimed != claimed_) && running_) {
    for (std::size_t i = 0; i < fused.size(); ++i) offset_[i] = last_[i] - fused[i];
    faded_s_ = 0;
  }
  if (faded_s_ < fade_s_) {
    const double x = faded_s_ / fade_s_;
    const double left = 1 - x * x * (3 - 2 * x);
    for (std::size_t i = 0; i < fused.size(); ++i) addition_[i] = left * offset_[i];
    (void)current_->add(addition_, fused);  // limits before smoothness
    faded_s_ += input.period_s;
  }
  std::ranges::copy(fused, last_.begin());
  running_ = true;
  claimed_ = claimed;
  return true;
}

void StackSwitch::restart(const TaskInput& input) noexcept {
  (void)change(input);
  current_->start(input, nullptr);
  faded_s_ = fade_s_;
  running_ = false;
}

}  // namespace robotskin::control
