// The skin tasks of a stack: the touch moves what it touches (eq. 17, 25), or a frame of the robot's choice.
#pragma once

#include <string>
#include <vector>

#include "control/low_pass.hpp"
#include "control/skin_task.hpp"
#include "control/task.hpp"
#include "control/touched_bodies.hpp"

namespace robotskin::control {

// The skin task; claims one row for each touched body, the motion along the wrench that it feels. Its torque is the sum
// of the host or the skin's own, whichever is asked for (skin_source.hpp).
class SkinReactionTask final : public Task {
 public:
  // Torques are filtered at `bandwidth_hz` (0: not). `own_scale`: these gains over those that the cells have been told.
  // Throws ModelError, ControlError.
  SkinReactionTask(const RobotModel& robot, const skin::SkinModel& skin, const SkinGains& gains,
                   double bandwidth_hz = 0, double period_s = 0.001, double own_scale = 1);
  void start(const TaskInput&) noexcept override { filter_.prime(); }
  [[nodiscard]] bool update(const TaskInput& input) noexcept override;
  std::span<const float> magnitudes() const noexcept { return skin_task_.magnitudes(); }  // (N) newton
  std::span<const double> host_torque() const noexcept { return asked_; }                 // (n) Nm, the host's sum
  double source_share() const noexcept { return source_.share(); }  // 1: all of the torque is the skin's own

  static constexpr double source_fade_s = 0.25;

 private:
  SkinTask skin_task_;
  TouchedBodies bodies_;
  SkinSourceSwitch source_;
  LowPass filter_;
  double own_scale_;
  std::vector<double> asked_;  // (n) Nm before the filter
};

// Every touch of a limb moves the frame of one of its links: torque = J_v^T F, F the sum of the cells' forces in the
// base frame and J_v the frame's translation. The limb is what lies between the base and the link, and what the link
// carries; cells elsewhere do nothing. Claims 3 rows.
class SkinCartesianTask final : public Task {
 public:
  // Throws ModelError for an unknown link, ControlError for a link on the base or gains that do not fit the skin.
  SkinCartesianTask(const RobotModel& robot, const skin::SkinModel& skin, const SkinGains& gains,
                    const std::string& link, double bandwidth_hz = 0, double period_s = 0.001);
  void start(const TaskInput&) noexcept override { filter_.prime(); }
  [[nodiscard]] bool update(const TaskInput& input) noexcept override;
  const Vector3& force() const noexcept { return force_; }  // newton, base frame, before the filter

 private:
  SkinTask skin_task_;
  TouchedBodies bodies_;
  LowPass filter_;
  std::size_t link_, link_joint_;
  std::vector<bool> limb_;  // (bodies)
  Vector3 force_{};
  std::vector<double> jacobian_, ignored_;  // (6, n), (n)
};

}  // namespace robotskin::control
