// SPDX-License-Identifier: Apache-2.0
// What every task of the library is: torques on the joints, and the motions that it lays claim to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "control/skin_source.hpp"
#include "model/robot_dynamics.hpp"
#include "skin/skin_state.hpp"

namespace robotskin::control {

class TouchWrench;
struct StandingState;

// What a task may know of one tick: n joints, N cells.
struct TaskInput {
  const RobotDynamics& dynamics;     // updated with position and velocity
  std::span<const double> position;  // (n) rad
  std::span<const double> velocity;  // (n) rad/s
  const skin::SkinState& skin;
  std::span<const float> share;  // (N) 0 to 1, how much of each cell counts
  double period_s;
  // What the skin has computed itself, null where it does not, and whose sum tasks of touch are to use.
  const skin::SkinTorque* skin_computed_torque = nullptr;
  SkinSource source = SkinSource::host;
  double skin_share = 1;  // 0 to 1, how much the skin counts at all; part of `share`
  // Another one every tick, so that what tasks share is computed once in it; 0: nothing is shared.
  std::uint64_t tick = 0;
  // When the fusion has to have ended, of StepBudget's clock; 0: no clock ends it.
  std::int64_t deadline_ns = 0;
  // All that touches the skin, as it is felt, whatever counts of it for tasks of touch; null: it is not known.
  const TouchWrench* touch = nullptr;
  // Of a robot that stands on its feet; null: it is mounted.
  const StandingState* standing = nullptr;
  // (n, n) the inertia that answers to torques, and (n) the torque of no acceleration: torque = mass a + bias gives the
  // acceleration a. Empty: those of the robot's own dynamics.
  std::span<const double> mass = {}, bias = {};
  // (n) Nm of all that touches the skin, filtered; the bias holds it already. Empty: nothing.
  std::span<const double> touch_torque = {};
  // The robot was stopped and goes on balancing only: a task stays where it began, and drops what it is asked for.
  bool held = false;
};

// What a task states: a torque, of which its level may leave a part, or the accelerations that its rows are to have.
enum class Asks : std::uint8_t { torque, acceleration };

// A task owns its results and has room for them from the start: update allocates, locks and throws nothing. A user's
// task derives from this class and fills torque_ and rows_.
class Task {
 public:
  // `largest_rows` bounds the rows of every tick.
  Task(std::string name, std::size_t joint_count, std::size_t largest_rows, Asks asks = Asks::torque)
      : torque_(joint_count),
        rows_(joint_count * largest_rows),
        acceleration_(asks == Asks::acceleration ? largest_rows : 0),
        name_(std::move(name)),
        largest_rows_(largest_rows),
        asks_(asks) {}
  virtual ~Task() = default;
  Task(const Task&) = delete;
  Task& operator=(const Task&) = delete;

  // Begins where the robot is: called in the tick in which the task enters a stack, and while the robot holds still.
  virtual void start(const TaskInput&) noexcept {}
  // Fills torque and rows. False if they could not be computed; the robot is then stopped.
  [[nodiscard]] virtual bool update(const TaskInput& input) noexcept = 0;

  const std::string& name() const noexcept { return name_; }
  std::size_t joint_count() const noexcept { return torque_.size(); }
  std::size_t largest_rows() const noexcept { return largest_rows_; }
  std::size_t row_count() const noexcept { return row_count_; }
  Asks asks() const noexcept { return asks_; }
  // How a programme of the task's own ended its last update: before it was exact, and by the clock.
  bool cut() const noexcept { return cut_; }
  bool cut_by_clock() const noexcept { return cut_by_clock_; }

  // (n) Nm that the task asks for, of which a task of a higher level may leave only a part.
  std::span<const double> torque() const noexcept { return torque_; }
  // (row_count, n) the motions, a row each, that tasks of lower levels must leave alone. A row shrinks to nothing as
  // its task fades, so that no torque of a lower level steps.
  std::span<const double> rows() const noexcept { return {rows_.data(), row_count_ * torque_.size()}; }
  // (row_count) rad/s^2 or m/s^2 that the rows are to have, as far as higher levels leave it; empty for a task that
  // asks for a torque.
  std::span<const double> acceleration() const noexcept {
    return {acceleration_.data(), asks_ == Asks::acceleration ? row_count_ : 0};
  }

 protected:
  std::vector<double> torque_;
  std::vector<double> rows_;
  std::vector<double> acceleration_;
  std::size_t row_count_ = 0;
  bool cut_ = false, cut_by_clock_ = false;

 private:
  std::string name_;
  std::size_t largest_rows_;
  Asks asks_;
};

}  // namespace robotskin::control
