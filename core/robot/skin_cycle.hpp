// The skin cycle: joint state and skin state in, joint command out, once a period. The page that shows the whole flow
// of stages 7 and 8.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "control/fade.hpp"
#include "control/joint_task.hpp"
#include "control/low_pass.hpp"
#include "control/patch_mask.hpp"
#include "control/skin_source.hpp"
#include "control/skin_task.hpp"
#include "control/torque_resolver.hpp"
#include "model/joint_command.hpp"
#include "model/joint_state.hpp"
#include "robot/guard.hpp"
#include "skin/skin_state.hpp"
#include "skin/torque_reader.hpp"

namespace robotskin::robot {

struct CycleGains {
  control::JointGains joint;
  control::SkinGains skin;
  control::ResolverGains resolver;  // its period is the cycle's
  double skin_bandwidth_hz = 0;     // of the torques from the skin, 0: unfiltered
  double fade_s = 0.25;             // how long switching the skin task or a patch takes
  double goal_speed = 0.5;          // rad/s, how fast the joint reference moves to a new goal
};

// Skin compliance (fig. 11): joint, gravity and skin task, fused by weights. The robot holds a reference posture and
// gives way to touch. Requests may come from any thread; step belongs to one.
class SkinCycle {
 public:
  // Throws ModelError, ControlError or GuardError for a robot, a skin, gains and limits that do not fit together.
  SkinCycle(const RobotModel& robot, const skin::SkinModel& skin, CycleGains gains, const GuardLimits& limits);

  // One period. `joints` holds n joints and `skin` N cells; `now_ns` is the clock of their stamps. Fills the command,
  // which has n joints; it goes to the robot if the report says `send`. Never allocates, locks or throws.
  // `own_torque`: what the skin has computed itself, if it does.
  const GuardReport& step(const JointState& joints, const skin::SkinState& skin, std::int64_t now_ns,
                          JointCommand& command, const skin::SkinTorque* own_torque = nullptr) noexcept;

  void request_run(bool run) noexcept { run_.store(run, std::memory_order_relaxed); }
  void request_mode(CommandMode mode) noexcept { mode_.store(mode, std::memory_order_relaxed); }
  // Whose torque the skin task contributes; masks of patches hold for the host's alone.
  void request_skin_source(control::SkinSource source) noexcept { source_.store(source, std::memory_order_relaxed); }
  void request_skin_task(bool on) noexcept { skin_on_.store(on, std::memory_order_relaxed); }
  // False if there is no such patch.
  [[nodiscard]] bool request_patch_mask(std::size_t patch, bool masked) noexcept {
    return mask_.request(patch, masked);
  }
  // goal (n) rad, to which the reference moves at the goal speed; the first is where the robot starts to run. False if
  // the count is wrong, a value is not finite or outside the position limits.
  [[nodiscard]] bool request_goal(std::span<const double> goal) noexcept;

  std::size_t joint_count() const noexcept { return reference_.size(); }
  std::size_t cell_count() const noexcept { return skin_task_.cell_count(); }
  std::size_t patch_count() const noexcept { return mask_.patch_count(); }

  // What the last step computed, in the order of the robot's joints: Nm, rad.
  std::span<const double> joint_torque() const noexcept { return joint_torque_; }
  std::span<const double> gravity_torque() const noexcept { return gravity_torque_; }
  std::span<const double> skin_torque() const noexcept { return skin_torque_; }  // before its weight and filter
  std::span<const double> host_skin_torque() const noexcept { return host_skin_torque_; }  // the host's, used or not
  double skin_source_share() const noexcept { return skin_source_.share(); }       // 1: all of it is the skin's own
  std::span<const double> touch_torque() const noexcept { return touch_torque_; }  // of the measured forces alone
  std::span<const double> fused_torque() const noexcept { return fused_torque_; }
  std::span<const double> reference() const noexcept { return reference_; }
  std::span<const float> cell_magnitudes() const noexcept { return skin_task_.magnitudes(); }  // (N) newton
  const GuardReport& report() const noexcept { return guard_.report(); }

 private:
  void follow_goal(const JointState& joints) noexcept;

  CycleGains gains_;
  RobotDynamics dynamics_;
  control::SkinTask skin_task_, touch_task_;
  control::PatchMask mask_;
  control::SkinSourceSwitch skin_source_;
  control::Fade skin_fade_;
  control::LowPass skin_filter_, touch_filter_;
  control::TorqueResolver resolver_;
  Guard guard_;

  std::vector<double> lower_, upper_;
  std::vector<double> reference_;          // (n) rad
  std::vector<std::atomic<double>> goal_;  // (n) rad
  std::vector<double> joint_torque_, gravity_torque_, host_skin_torque_, skin_torque_, touch_torque_, fused_torque_;
  std::atomic<bool> run_{false}, skin_on_{true}, goal_given_{false};
  std::atomic<control::SkinSource> source_{control::SkinSource::host};
  std::atomic<CommandMode> mode_{CommandMode::position};
};

}  // namespace robotskin::robot
