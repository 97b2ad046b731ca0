// SPDX-License-Identifier: Apache-2.0
// Map skin task (IV-A): touch turned into joint torques by a learnt sensory-motor map, without any model of the robot.
#pragma once

#include <vector>

#include "control/skin_activation.hpp"
#include "control/task.hpp"

namespace robotskin::control {

// Weights w in -1 to 1 of T postures, N cells and n joints, as `SensoryMotorMap` holds them: the share of a joint's
// motion that moves a cell along its outward normal.
struct SkinMap {
  std::vector<double> posture;  // (T, n) rad
  std::vector<double> weight;   // (T, N, n)
};

// torque = -lever sum over cells of a w, a what the cell asks for [Cheng19 eq. 14]. The tile whose posture is nearest
// is recalled, and fades in over fade_s where another becomes the nearest. Claims one row, the joint motion that the
// touch asks for.
class MapSkinTask final : public Task {
 public:
  // lever in metres, > 0. Throws ControlError for a map of another size, without postures or with values that are not
  // finite.
  MapSkinTask(std::size_t joint_count, std::size_t cell_count, const SkinGains& gains, SkinMap map, double lever);
  void start(const TaskInput& input) noexcept override;
  [[nodiscard]] bool update(const TaskInput& input) noexcept override;
  std::size_t recalled() const noexcept { return nearest_; }  // index of the tile

  static constexpr double fade_s = 0.25;

 private:
  void recall(std::span<const double> position) noexcept;

  SkinActivation activation_;
  SkinMap map_;
  double lever_;
  std::vector<double> tile_share_;    // (T) sum 1
  skin::CellArray<float> magnitude_;  // (N)
  std::size_t nearest_ = 0;
};

}  // namespace robotskin::control
