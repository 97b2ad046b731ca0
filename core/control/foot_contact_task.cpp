// SPDX-License-Identifier: Apache-2.0
#include "control/foot_contact_task.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "control/control_error.hpp"
#include "control/standing_state.hpp"
#include "model/spatial.hpp"

namespace robotskin::control {

FootContactTask::FootContactTask(const RobotModel& robot, const std::vector<Foot>& feet, FootContactGains gains)
    : Task("foot contact", robot.joint_count(), 12, Asks::acceleration), gains_(gains) {
  for (const double value : {gains.stiffness, gains.damping, gains.flattening, gains.largest_turn})
    if (!(value >= 0) || !std::isfinite(value))
      throw ControlError("foot contact task: gain " + std::to_string(value) + " must be finite and not negative");
  if (feet.size() != link_.size())
    throw ControlError("foot contact task: the robot has " + std::to_string(feet.size()) + " feet, there must be 2");
  for (std::size_t i = 0; i < link_.size(); ++i) {
    link_[i] = robot.link_index(feet[i].link);
    half_[i] = feet[i].half;
  }
}

void FootContactTask::start(const TaskInput& input) noexcept {
  for (std::size_t i = 0; i < link_.size(); ++i) {
    (void)input.dynamics.base_from_link(link_[i], begin_[i]);
    turned_[i] = {};
  }
}

// A foot's moment about its own middle turns it: about x by what presses beside, and about y by what presses ahead of
// where the whole robot presses. Beside means outwards beyond the zero-moment point's own place.
void FootContactTask::flatten(const TaskInput& input) noexcept {
  const StandingState* state = input.standing;
  if (state == nullptr || !state->forces_count || gains_.flattening == 0) return;
  for (std::size_t i = 0; i < link_.size(); ++i) {
    const double load = state->foot_load_n[i];
    const double ahead = std::clamp(state->zmp[0] - state->foot_place[i][0], -half_[i][0], half_[i][0]);
    const double aside = state->zmp[1] - state->foot_place[i][1];
    const bool left = state->foot_place[i][1] > state->foot_place[1 - i][1];
    const double wanted = std::clamp(left ? std::max(aside, 0.0) : std::min(aside, 0.0), -half_[i][1], half_[i][1]);
    const double rate[2] = {load * (state->foot_pressure[i][1] - wanted), -load * (state->foot_pressure[i][0] - ahead)};
    for (std::size_t axis = 0; axis < 2; ++axis)
      turned_[i][axis] = std::clamp(turned_[i][axis] + input.period_s * gains_.flattening * rate[axis],
                                    -gains_.largest_turn, gains_.largest_turn);
  }
}

bool FootContactTask::update(const TaskInput& input) noexcept {
  flatten(input);
  const std::size_t joints = joint_count();
  row_count_ = 12;
  for (std::size_t i = 0; i < link_.size(); ++i) {
    double* rows = &rows_[6 * i * joints];
    double pose[16];
    if (!input.dynamics.base_from_link(link_[i], pose) || !input.dynamics.link_jacobian(link_[i], {rows, 6 * joints}))
      return false;
    const Vector3 place = origin_of(begin_[i].data()) - origin_of(pose);
    const Vector3 turn = rotation_between(pose, begin_[i].data()) + Vector3{turned_[i][0], turned_[i][1], 0};
    for (std::size_t row = 0; row < 6; ++row) {
      double speed = 0;
      for (std::size_t k = 0; k < joints; ++k) speed += rows[row * joints + k] * input.velocity[k];
      const double error = row < 3 ? place[row] : turn[row - 3];
      acceleration_[6 * i + row] = gains_.stiffness * error - gains_.damping * speed;
    }
  }
  return true;
}

}  // namespace robotskin::control
