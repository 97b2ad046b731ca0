// SPDX-License-Identifier: Apache-2.0
// A stack of tasks: which tasks, on which levels, fused in which way. Its make-up is constant.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "control/null_space_fusion.hpp"
#include "control/quadratic_fusion.hpp"
#include "control/task.hpp"

namespace robotskin::control {

// weighted_sum: [Cheng19 eq. 18], levels mean nothing. null_space: [Cheng19 eq. 19, 20], dynamically consistent.
// null_space_at_rest: the same with Moore-Penrose inverses. quadratic: a quadratic programme a level, within the
// robot's limits.
enum class Fusion : std::uint8_t { weighted_sum, null_space, null_space_at_rest, quadratic };

struct StackEntry {
  // Of a task that no level projects and that claims nothing, such as gravity.
  static constexpr int feedforward = -1;

  std::shared_ptr<Task> task;
  int level = 0;      // 0 is the highest; tasks of one level are added up
  double weight = 1;  // of the torque (w_k of [Cheng19 eq. 18])
};

class TaskStack {
 public:
  // `limits` are needed for Fusion::quadratic. Throws ControlError for a stack without tasks, a task that is missing,
  // twice there or of another robot, a level below `feedforward`, a weight that is negative or not finite, no limits,
  // or a task that asks for accelerations beside one that asks for a torque, as a feedforward, or in a fusion without
  // levels.
  TaskStack(std::size_t joint_count, std::vector<StackEntry> entries, Fusion fusion, Damping damping = {},
            std::optional<QuadraticLimits> limits = {});

  // Starts those tasks that `before`, which may be null, does not hold.
  void start(const TaskInput& input, const TaskStack* before) noexcept;
  // fused (n) Nm. `mass` (n, n) is the inertia that answers to torques, `bias` (n) Nm the torque of no acceleration.
  // False if a task or the fusion has no finite answer. Allocates nothing.
  [[nodiscard]] bool compute(const TaskInput& input, std::span<const double> mass, std::span<const double> bias,
                             std::span<double> fused) noexcept;

  std::size_t joint_count() const noexcept { return joints_; }
  Fusion fusion() const noexcept { return fusion_; }
  std::span<const StackEntry> entries() const noexcept { return entries_; }  // by level
  bool holds(const Task* task) const noexcept;
  // How many directions the levels of a quadratic fusion claimed in the last compute, else 0: where this changes, so
  // may the torque, at once.
  std::size_t claimed() const noexcept { return quadratic_ ? quadratic_->claimed() : 0; }
  // How a quadratic fusion ended the last compute; another always finishes, without steps. Beside it, whether steps or
  // time ended a programme of a task's own.
  FusionReport report() const noexcept;
  // After compute: fused += addition (n) Nm, of which a quadratic fusion leaves only what keeps its limits. Returns the
  // share that was added.
  double add(std::span<const double> addition, std::span<double> fused) noexcept;

 private:
  std::size_t joints_;
  std::vector<StackEntry> entries_;
  Fusion fusion_;
  std::vector<FusionLevel> levels_;
  std::vector<double> level_torque_;        // (levels, n)
  std::vector<double> level_rows_;          // (largest rows of all, n)
  std::vector<double> level_acceleration_;  // (largest rows of all)
  std::vector<double> feedforward_;         // (n)
  std::vector<double> beside_;              // (n) Nm, what moves the robot beside the levels
  std::optional<NullSpaceFusion> null_space_;
  std::optional<QuadraticFusion> quadratic_;
};

}  // namespace robotskin::control
