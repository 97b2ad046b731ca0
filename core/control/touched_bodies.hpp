// The skin's wrenches body by body, turned to the base: what the skin tasks of a stack have in common.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "control/skin_task.hpp"
#include "control/spatial.hpp"

namespace robotskin::control {

class TouchedBodies {
 public:
  TouchedBodies(const RobotModel& robot, const skin::SkinModel& skin);

  std::size_t count() const noexcept { return joint_.size(); }  // bodies with cells that move
  std::size_t joint(std::size_t body) const noexcept { return joint_[body]; }
  // True if the body is carried by the joint or is the joint's own.
  bool carried_by(std::size_t body, std::size_t joint) const noexcept { return carried_[body * joint_count_ + joint]; }

  // The wrench (24) of one body: force, newton, and moment about the base's origin, both along the axes of the base.
  struct Wrench {
    Vector3 force, moment;
  };
  Wrench wrench(const RobotDynamics& dynamics, std::span<const double> joint_wrenches, std::size_t body) const noexcept;
  // torque (n) = factor J^T wrench.
  void torque(const RobotDynamics& dynamics, std::size_t body, const Wrench& wrench, double factor,
              double* torque) const noexcept;

 private:
  std::size_t joint_count_;
  std::vector<std::size_t> joint_;      // (bodies)
  std::vector<unsigned char> carried_;  // (bodies, n)
};

// Share of a claim that a force of this size makes: 0 without touch, without a step or a kink to 1.
inline double touch_share(double force_n) noexcept {
  constexpr double half_n = 1.0;
  return force_n * force_n / (force_n * force_n + half_n * half_n);
}

}  // namespace robotskin::control
