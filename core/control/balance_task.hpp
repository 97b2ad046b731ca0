// SPDX-License-Identifier: Apache-2.0
// Balance: moves the centre of mass so that the floor can carry what the robot, and those who push it, ask of it.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "control/standing_state.hpp"
#include "control/task.hpp"
#include "model/robot_model.hpp"

namespace robotskin::control {

struct BalanceGains {
  double lean = 0.6;                       // share of a lasting push that leaning against it takes up
  double lean_hz = 0.5;                    // how fast it leans
  double largest_lean_m = 0.07;            // of the capture point from the middle of the soles, by leaning
  double lean_feedforward = 1;             // share of the lean's own speed that is fed forward
  double capture = 2;                      // how far the zero-moment point goes beyond the capture point's error
  double admittance = 2;                   // 1/s, of the centre of mass by the error of the zero-moment point
  double margin_m = 0.006;                 // by which the zero-moment point stays inside the soles
  double largest_speed = 0.6;              // m/s of the centre of mass
  double largest_lead_m = 0.05;            // by which the wanted centre of mass may be ahead of the estimated one
  double stiffness = 2500, damping = 100;  // 1/s^2 and 1/s, of the robot's centre of mass by the wanted one
  double touch_hz = 8;                     // low-pass of what the skin feels
  double rest_hz = 0.5;                    // how fast the feet tell what the skin does not feel
  bool by_skin = true;                     // the shift of a touch is fed forward from the skin
  bool by_feet = true;                     // the zero-moment point is measured
};

// With the centre of mass c at height h, w = sqrt(g / h), the capture point x = c + c' / w, the zero-moment point p,
// and the shift d = M / (m g) of the point of balance by a touch, where M is the touch's moment about the point of the
// floor under c:
//   x* = centre of the soles - lean low_pass(d), largest_lean_m at most
//   p* = what the soles allow of  x* + d + capture (x - x*) - x*' / w
//   c*' = x*' as far as the soles allow it, between 0 and w (x + d - p*), + admittance (p - p*)
// The rows are those of the centre of mass along x and y. Where no foot tells its force, c* goes to x* slowly.
class BalanceTask final : public Task {
 public:
  // Throws ControlError for gains that are not finite and not negative.
  explicit BalanceTask(const RobotModel& robot, BalanceGains gains = {});
  void start(const TaskInput& input) noexcept override;
  [[nodiscard]] bool update(const TaskInput& input) noexcept override;

  const Vector2& wanted() const noexcept { return wanted_; }          // metres, c*
  const Vector2& shift() const noexcept { return shift_; }            // metres, d
  const Vector2& skin_shift() const noexcept { return skin_shift_; }  // metres, the part of it that the skin feels
  const Vector2& pressed() const noexcept { return pressed_; }        // metres, p*

 private:
  Vector2 felt(const TaskInput& input, const Vector3& centre) const noexcept;
  void follow(const TaskInput& input) noexcept;

  BalanceGains gains_;
  std::vector<double> jacobian_;  // (3, n)
  Vector2 wanted_{}, speed_{}, shift_{}, skin_shift_{}, rest_{}, slow_{}, pressed_{};
  double begun_s_ = 0;  // since the task entered
};

}  // namespace robotskin::control
