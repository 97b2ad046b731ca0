// SPDX-License-Identifier: Apache-2.0
#include "control/task_stack.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "control/control_error.hpp"

namespace robotskin::control {

TaskStack::TaskStack(std::size_t joint_count, std::vector<StackEntry> entries, Fusion fusion, Damping damping,
                     std::optional<QuadraticLimits> limits)
    : joints_(joint_count),
      entries_(std::move(entries)),
      fusion_(fusion),
      feedforward_(joint_count),
      beside_(joint_count) {
  if (entries_.empty()) throw ControlError("task stack: there is no task in it");
  std::size_t largest_rows = 0;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const StackEntry& entry = entries_[i];
    if (!entry.task) throw ControlError("task stack: entry " + std::to_string(i) + " has no task");
    const std::string& name = entry.task->name();
    for (std::size_t k = 0; k < i; ++k)
      if (entries_[k].task == entry.task) throw ControlError("task stack: task '" + name + "' is in it twice");
    if (entry.task->joint_count() != joints_)
      throw ControlError("task stack: task '" + name + "' is for " + std::to_string(entry.task->joint_count()) +
                         " joints, the robot has " + std::to_string(joints_));
    if (entry.level < StackEntry::feedforward)
      throw ControlError("task stack: level " + std::to_string(entry.level) + " of task '" + name +
                         "' must be 0 or more, or -1 for feedforward");
    if (!std::isfinite(entry.weight) || entry.weight < 0)
      throw ControlError("task stack: weight " + std::to_string(entry.weight) + " of task '" + name +
                         "' must be finite and not negative");
    if (entry.level != StackEntry::feedforward) largest_rows += entry.task->largest_rows();
  }
  std::ranges::stable_sort(entries_, {}, &StackEntry::level);
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (entries_[i].task->asks() != Asks::acceleration) continue;
    const std::string name = "task stack: task '" + entries_[i].task->name() + "', which asks for accelerations, ";
    if (fusion != Fusion::null_space && fusion != Fusion::quadratic)
      throw ControlError(name + "needs a fusion by levels: null_space or quadratic");
    if (entries_[i].level == StackEntry::feedforward) throw ControlError(name + "needs a level");
    for (const StackEntry& other : entries_)
      if (other.level == entries_[i].level && other.task->asks() != Asks::acceleration)
        throw ControlError(name + "shares level " + std::to_string(other.level) + " with '" + other.task->name() +
                           "', which asks for a torque");
  }
  std::size_t levels = 0;
  for (std::size_t i = 0; i < entries_.size(); ++i)
    if (entries_[i].level != StackEntry::feedforward && (i == 0 || entries_[i].level != entries_[i - 1].level))
      ++levels;
  levels_.resize(levels);
  level_torque_.resize(levels * joints_);
  level_rows_.resize(largest_rows * joints_);
  level_acceleration_.resize(largest_rows);

  if (fusion == Fusion::null_space)
    null_space_.emplace(joints_, largest_rows, Inverse::dynamically_consistent, damping);
  if (fusion == Fusion::null_space_at_rest) null_space_.emplace(joints_, largest_rows, Inverse::moore_penrose, damping);
  if (fusion == Fusion::quadratic) {
    if (!limits) throw ControlError("task stack: quadratic fusion needs the robot's limits");
    quadratic_.emplace(joints_, largest_rows, levels, std::move(*limits));
  }
}

bool TaskStack::holds(const Task* task) const noexcept {
  return std::ranges::any_of(entries_, [task](const StackEntry& entry) { return entry.task.get() == task; });
}

void TaskStack::start(const TaskInput& input, const TaskStack* before) noexcept {
  for (const StackEntry& entry : entries_)
    if (before == nullptr || !before->holds(entry.task.get())) entry.task->start(input);
  if (quadratic_) quadratic_->restart();
}

FusionReport TaskStack::report() const noexcept {
  FusionReport report = quadratic_ ? quadratic_->report() : FusionReport{};
  for (const StackEntry& entry : entries_) {
    report.fallback = report.fallback || entry.task->cut();
    report.by_clock = report.by_clock || entry.task->cut_by_clock();
  }
  return report;
}

double TaskStack::add(std::span<const double> addition, std::span<double> fused) noexcept {
  if (quadratic_) return quadratic_->add_within_limits(addition, fused);
  for (std::size_t i = 0; i < fused.size(); ++i) fused[i] += addition[i];
  return 1;
}

bool TaskStack::compute(const TaskInput& input, std::span<const double> mass, std::span<const double> bias,
                        std::span<double> fused) noexcept {
  std::ranges::fill(feedforward_, 0.0);
  std::ranges::fill(level_torque_, 0.0);
  double* torque = feedforward_.data();
  double* rows = level_rows_.data();
  double* acceleration = level_acceleration_.data();
  std::size_t level = 0;  // of the next new one
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const StackEntry& entry = entries_[i];
    if (!entry.task->update(input)) return false;
    const bool projected = entry.level != StackEntry::feedforward;
    if (projected && (i == 0 || entry.level != entries_[i - 1].level)) {
      torque = &level_torque_[level * joints_];
      levels_[level++] = {{torque, joints_}, {rows, 0}};
    }
    const std::span<const double> own = entry.task->torque();
    for (std::size_t joint = 0; joint < joints_; ++joint)
      torque[joint] += entry.weight * own[joint];  // [Cheng19 eq. 18]
    if (!projected) continue;
    std::ranges::copy(entry.task->rows(), rows);
    rows += entry.task->rows().size();
    const double* first = levels_[level - 1].rows.data();
    levels_[level - 1].rows = {first, static_cast<std::size_t>(rows - first)};
    const std::span<const double> wanted = entry.task->acceleration();
    std::ranges::copy(wanted, acceleration);
    acceleration += wanted.size();
    if (!wanted.empty()) {
      const std::size_t so_far = levels_[level - 1].acceleration.size() + wanted.size();
      levels_[level - 1].acceleration = {acceleration - so_far, so_far};
    }
  }
  switch (fusion_) {
    case Fusion::weighted_sum:
      std::ranges::fill(fused, 0.0);
      for (const FusionLevel& one : levels_)
        for (std::size_t joint = 0; joint < joints_; ++joint) fused[joint] += one.torque[joint];
      break;
    case Fusion::null_space:
    case Fusion::null_space_at_rest:
      for (std::size_t joint = 0; joint < joints_; ++joint) beside_[joint] = feedforward_[joint] - bias[joint];
      if (!null_space_->fuse(mass, levels_, fused, beside_)) return false;
      break;
    case Fusion::quadratic:
      return quadratic_->fuse(input, mass, bias, feedforward_, levels_, fused);
  }
  for (std::size_t joint = 0; joint < joints_; ++joint) fused[joint] += feedforward_[joint];
  return std::ranges::all_of(fused, [](double value) { return std::isfinite(value); });
}

}  // namespace robotskin::control
