// SPDX-License-Identifier: Apache-2.0
#include "health/link_motion.hpp"

#include <algorithm>
#include <cmath>

#include "model/spatial.hpp"
#include "skin/calibration.hpp"

namespace robotskin::health {

LinkMotion::LinkMotion(const RobotModel& robot, const std::vector<std::string>& links, double period_s,
                       double low_pass_s)
    : dynamics_(robot),
      jacobian_(6 * robot.joint_count()),
      pose_(16),
      last_(links.size()),
      force_(links.size()),
      period_ns_(static_cast<std::int64_t>(period_s * 1e9)),
      low_pass_s_(low_pass_s) {
  for (const std::string& link : links) links_.push_back(robot.link_index(link));
}

bool LinkMotion::update(std::int64_t now_ns, std::span<const double> position,
                        std::span<const double> velocity) noexcept {
  const std::int64_t passed_ns = now_ns - last_ns_;
  if (updates_ > 0 && passed_ns >= 0 && passed_ns < period_ns_) return known_;
  if (!dynamics_.update(position, velocity)) return false;
  const double passed_s = 1e-9 * static_cast<double>(passed_ns);
  // After a pause nothing is known of accelerations.
  const bool goes_on = updates_ > 0 && passed_ns > 0 && passed_ns < 10 * period_ns_;
  if (!goes_on) updates_ = 0;
  const double share = low_pass_s_ > 0 ? 1 - std::exp(-passed_s / low_pass_s_) : 1;
  const std::size_t joints = velocity.size();
  for (std::size_t k = 0; k < links_.size(); ++k) {
    if (!dynamics_.base_from_link(links_[k], pose_) || !dynamics_.link_jacobian(links_[k], jacobian_)) return false;
    Vector3 linear{}, turn{};
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t j = 0; j < joints; ++j) {
        linear[row] += jacobian_[row * joints + j] * velocity[j];
        turn[row] += jacobian_[(row + 3) * joints + j] * velocity[j];
      }
    Last& last = last_[k];
    for (std::size_t i = 0; i < 3; ++i) {
      if (goes_on) {
        last.acceleration[i] += share * ((linear[i] - last.velocity[i]) / passed_s - last.acceleration[i]);
        last.turn_rate[i] += share * ((turn[i] - last.turn[i]) / passed_s - last.turn_rate[i]);
      } else {
        last.acceleration[i] = last.turn_rate[i] = 0;
      }
      last.velocity[i] = linear[i];
      last.turn[i] = turn[i];
    }
    const Matrix3 base_from_link{pose_[0], pose_[1], pose_[2], pose_[4], pose_[5],
                                 pose_[6], pose_[8], pose_[9], pose_[10]};
    Vector3 felt = last.acceleration;
    felt[2] += skin::standard_gravity;
    force_[k].origin = apply_transposed(base_from_link, felt);
    const Vector3 w = apply_transposed(base_from_link, turn), a = apply_transposed(base_from_link, last.turn_rate);
    const double square = dot(w, w);
    force_[k].gradient = {w[0] * w[0] - square, w[0] * w[1] - a[2],   w[0] * w[2] + a[1],
                          w[1] * w[0] + a[2],   w[1] * w[1] - square, w[1] * w[2] - a[0],
                          w[2] * w[0] - a[1],   w[2] * w[1] + a[0],   w[2] * w[2] - square};
  }
  last_ns_ = now_ns;
  known_ = ++updates_ > 5;
  return known_;
}

}  // namespace robotskin::health
