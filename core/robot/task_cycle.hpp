// SPDX-License-Identifier: Apache-2.0
// The task cycle: joint state and skin state in, the tasks of a stack fused, joint command out, once a period.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "control/fade.hpp"
#include "control/low_pass.hpp"
#include "control/patch_mask.hpp"
#include "control/skin_source.hpp"
#include "control/stack_switch.hpp"
#include "control/standing_estimator.hpp"
#include "control/torque_resolver.hpp"
#include "control/touch_wrench.hpp"
#include "model/joint_command.hpp"
#include "model/joint_state.hpp"
#include "model/sensor_readings.hpp"
#include "robot/guard.hpp"
#include "robot/state_log.hpp"
#include "skin/skin_state.hpp"

namespace robotskin::robot {

struct TaskCycleGains {
  control::SkinGains touch;         // which cells' forces count as a touch; the weights are not read
  control::ResolverGains resolver;  // its period is the cycle's
  double touch_bandwidth_hz = 0;    // of the measured touch, 0: unfiltered
  double fade_s = 0.25;             // how long switching the stack, the skin or a patch takes
  // After which a clock ends the fusion of a period: for the ports of a real robot alone, since no run that it ends
  // can be repeated; 0: none does.
  double fusion_ends_s = 0;
  std::vector<Foot> feet;  // of a robot that stands on them; empty: it is mounted
};

// How the ticks of quadratic programmes ended, of a cycle so far.
struct FusionCounts {
  std::uint64_t fallback_ticks = 0;      // their solver steps, or their time, ended before all levels were exact
  std::uint64_t clock_ticks = 0;         // those that the clock ended
  std::uint64_t fade_limited_ticks = 0;  // a limit forbade that the torque went on without a step
  std::uint64_t widened_ticks = 0;       // no torque kept all limits, so that those of acceleration gave way
  std::uint64_t most_steps = 0;          // of one tick
};

// Any behaviour: a stack of tasks, fused (18) or (19), through the torque resolver and past the guard. Requests may
// come from any thread, those for a stack from one; step belongs to one.
class TaskCycle {
 public:
  // Throws ModelError, ControlError or GuardError for a robot, a skin, gains, limits and a stack that do not fit
  // together.
  TaskCycle(const RobotModel& robot, const skin::SkinModel& skin, TaskCycleGains gains, const GuardLimits& limits,
            std::unique_ptr<control::TaskStack> stack);

  // Which sensors the readings of `estimate` are of. Throws ModelError for a link that the robot does not have.
  void use_sensors(const PortSensors& sensors);
  // Fills the joints of the base of a robot that stands; of one that is mounted it changes nothing. Before each step.
  void estimate(const SensorReadings& sensors, std::int64_t now_ns, JointState& joints) noexcept;
  // Of a robot that stands, after estimate; null: it is mounted, or nothing is known yet.
  const control::StandingState* standing() const noexcept {
    return standing_ && standing_known_ ? &standing_->state() : nullptr;
  }

  // One period. `joints` holds n joints and `skin` N cells; `now_ns` is the clock of their stamps. Fills the command,
  // which has n joints; it goes to the robot if the report says `send`. Never allocates, locks or throws.
  // `skin_computed_torque`: what the skin has computed itself, if it does.
  const GuardReport& step(const JointState& joints, const skin::SkinState& skin, std::int64_t now_ns,
                          JointCommand& command, const skin::SkinTorque* skin_computed_torque = nullptr) noexcept;

  void request_run(bool run) noexcept { run_.store(run, std::memory_order_relaxed); }
  bool run_requested() const noexcept { return run_.load(std::memory_order_relaxed); }
  void request_mode(CommandMode mode) noexcept {
    for (auto& one : mode_) one.store(mode, std::memory_order_relaxed);
  }
  // Of each joint (n). False if there are not as many.
  [[nodiscard]] bool request_mode(std::span<const CommandMode> mode) noexcept {
    if (mode.size() != mode_.size()) return false;
    for (std::size_t i = 0; i < mode.size(); ++i) mode_[i].store(mode[i], std::memory_order_relaxed);
    return true;
  }
  // Share of the velocity limits that commands may use, above 0 to 1; of a robot that is not trusted yet.
  void request_speed_cap(double share) noexcept { speed_cap_.store(share, std::memory_order_relaxed); }
  double speed_cap() const noexcept { return speed_cap_.load(std::memory_order_relaxed); }
  // Whose torque skin tasks contribute; masks of patches hold for the host's alone.
  void request_skin_source(control::SkinSource source) noexcept { source_.store(source, std::memory_order_relaxed); }
  // Off: no task feels any cell.
  void request_skin(bool on) noexcept { skin_on_.store(on, std::memory_order_relaxed); }
  // False if there is no such patch.
  [[nodiscard]] bool request_patch_mask(std::size_t patch, bool masked) noexcept {
    return mask_.request(patch, masked);
  }
  // Leaves a cell out, as an ill one: it fades, and counts as not alive. False if there is no such cell.
  [[nodiscard]] bool request_cell_mask(std::size_t cell, bool masked) noexcept {
    return mask_.request_cell(cell, masked);
  }
  void request_stack(std::unique_ptr<control::TaskStack> stack) { stack_.request(std::move(stack)); }

  std::size_t joint_count() const noexcept { return fused_torque_.size(); }
  std::size_t cell_count() const noexcept { return touch_.cell_count(); }
  std::size_t patch_count() const noexcept { return mask_.patch_count(); }
  std::span<const double> touch_torque() const noexcept { return touch_.torque(); }  // (n) Nm of the forces felt
  std::span<const double> fused_torque() const noexcept { return fused_torque_; }    // (n) Nm
  const control::TaskStack& stack() const noexcept { return stack_.stack(); }
  void leave_stops_to_port(bool leave) noexcept { guard_.leave_stops_to_port(leave); }
  const GuardReport& report() const noexcept { return guard_.report(); }
  const FusionCounts& fusion_counts() const noexcept { return fusion_counts_; }
  const Guard& guard() const noexcept { return guard_; }
  // The last second before now, or before the robot stopped by a fault.
  const StateLog& log() const noexcept { return log_; }

 private:
  TaskCycleGains gains_;
  RobotDynamics dynamics_;
  control::TouchWrench touch_;  // as it is felt
  RobotModel robot_;
  std::optional<control::StandingEstimator> standing_;
  bool standing_known_ = false, balances_ = false, ran_ = false;
  control::PatchMask mask_;
  control::Fade skin_fade_;
  control::LowPass touch_filter_;
  control::StackSwitch stack_;
  control::TorqueResolver resolver_;
  Guard guard_;
  FusionCounts fusion_counts_;
  StateLog log_;
  std::vector<float> share_;          // (N)
  std::vector<double> fused_torque_;  // (n)
  std::vector<double> mass_, bias_;   // (n, n), (n)
  std::uint64_t tick_ = 0;
  std::atomic<bool> run_{false}, skin_on_{true};
  std::atomic<control::SkinSource> source_{control::SkinSource::host};
  std::atomic<double> speed_cap_{1};
  std::vector<std::atomic<CommandMode>> mode_;  // (n)
};

}  // namespace robotskin::robot
