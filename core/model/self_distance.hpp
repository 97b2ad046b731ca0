// SPDX-License-Identifier: Apache-2.0
// How near a robot's bodies are to each other: exact distances between convex hulls, for the few pairs that are near.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "model/robot_dynamics.hpp"
#include "model/robot_model.hpp"

namespace robotskin {

// Points whose convex hull stands for a body.
struct BodyHull {
  int joint = RobotModel::base;  // the joint that carries it, or base
  std::vector<double> points;    // (m, 3) metres, in the joint's frame, or the base's
};

// Two bodies that are near each other; everything in the base frame.
struct NearPair {
  std::size_t pair = 0;  // which of the pairs asked for
  int joint_a = RobotModel::base, joint_b = RobotModel::base;
  double distance_m = 0;                       // below 0 where they overlap
  std::array<double, 3> point_a{}, point_b{};  // the nearest points
  std::array<double, 3> a_to_b{};              // unit
};

class SelfDistance {
 public:
  // More pairs than these are never measured in one update; those whose spheres are nearest are.
  static constexpr std::size_t largest_measured = 30;

  // `pairs` are indices of hulls. Throws ModelError for a pair of one hull, an unknown hull or joint, a hull of fewer
  // than four points or without volume, and values that are not finite.
  SelfDistance(const RobotModel& robot, const std::vector<BodyHull>& hulls,
               std::vector<std::pair<std::size_t, std::size_t>> pairs);
  ~SelfDistance();
  SelfDistance(SelfDistance&&) noexcept;
  SelfDistance& operator=(SelfDistance&&) noexcept;

  // Measures the pairs whose bounding spheres are nearer than reach_m, at most largest_measured; the result holds those
  // nearer than reach_m, in the order of the pairs, and stays valid until the next update.
  std::span<const NearPair> update(const RobotDynamics& dynamics, double reach_m) noexcept;

  std::size_t pair_count() const noexcept;
  std::size_t measured() const noexcept;  // by the last update

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace robotskin
