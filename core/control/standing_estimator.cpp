// SPDX-License-Identifier: Apache-2.0
#include "control/standing_estimator.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "control/control_error.hpp"
#include "control/low_pass.hpp"

namespace robotskin::control {
namespace {

constexpr double tilt_s = 1.0;      // in which the tilt follows the unit's own, or that of the legs
constexpr double heading_s = 0.05;  // in which the heading follows the feet
constexpr double velocity_hz = 20, zmp_hz = 25;
constexpr std::int64_t stuck_ns = 50'000'000;  // a unit that says the same for so long is stuck
constexpr std::int64_t silent_ns = 20'000'000;
constexpr double least_load_n = 50;   // below which the feet carry nothing
constexpr double least_share_n = 20;  // of one foot, for a centre of pressure

bool finite(const Vector3& v) noexcept {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}
bool young(std::int64_t stamp_ns, std::int64_t now_ns, std::int64_t age_ns) noexcept {
  return stamp_ns <= now_ns && stamp_ns >= now_ns - age_ns;
}

// x of A x = b by Cramer's rule; columns of A are a, b, c.
Vector3 solved(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& right) noexcept {
  const double all = dot(a, cross(b, c));
  return {dot(right, cross(b, c)) / all, dot(a, cross(right, c)) / all, dot(a, cross(b, right)) / all};
}

}  // namespace

StandingEstimator::StandingEstimator(const RobotModel& robot, const std::vector<Foot>& feet)
    : dynamics_(robot),
      joints_(robot.joint_count()),
      position_(joints_),
      velocity_(joints_),
      jacobian_(6 * joints_),
      com_jacobian_(3 * joints_) {
  if (feet.size() != 2)
    throw ControlError("standing robot: it has " + std::to_string(feet.size()) + " feet, there must be 2");
  if (joints_ <= base_joints || robot.actuated(base_joints - 1))
    throw ControlError(
        "standing robot: the first six joints must be x, y, z, yaw, pitch and roll of its base, with an "
        "effort limit of 0");
  for (std::size_t i = 0; i < 2; ++i) {
    feet_[i].link = robot.link_index(feet[i].link);
    feet_[i].sole = feet[i].sole;
    feet_[i].half = feet[i].half;
    feet_[i].jacobian.resize(6 * joints_);
  }
}

void StandingEstimator::use_sensors(const RobotModel& robot, const PortSensors& sensors) {
  imu_ = sensors.imus.empty() ? none : 0;
  if (imu_ != none) {
    imu_link_ = robot.link_index(sensors.imus[0].link);
    link_from_imu_ = sensors.imus[0].link_from_sensor;
  }
  for (FootPlace& foot : feet_) {
    foot.sensor = none;
    for (std::size_t i = 0; i < sensors.forces.size(); ++i)
      if (robot.link_index(sensors.forces[i].link) == foot.link) foot.sensor = static_cast<int>(i);
  }
}

bool StandingEstimator::hear_imu(const SensorReadings& sensors, std::int64_t now_ns) noexcept {
  if (imu_ == none || sensors.imus.size() <= static_cast<std::size_t>(imu_)) return false;
  const ImuReading& now = sensors.imus[static_cast<std::size_t>(imu_)];
  const auto& up = now.up_from_sensor;
  if (!finite(now.angular_velocity) || !std::isfinite(up[6] + up[7] + up[8])) return false;
  // SAFETY: no unit without noise exists: one whose numbers stay the same repeats its last word.
  if (now.angular_velocity != heard_.angular_velocity) imu_changed_ns_ = now.stamp_ns;
  heard_ = now;
  return young(now.stamp_ns, now_ns, silent_ns) && young(imu_changed_ns_, now_ns, stuck_ns);
}

// Of yaw, pitch and roll, which turn the base so along the axes that these joints have now.
Vector3 StandingEstimator::base_rates(const Vector3& turn) const noexcept {
  const double* motions = dynamics_.joint_motions().data();
  return solved(load3(motions + 6 * 3 + 3), load3(motions + 6 * 4 + 3), load3(motions + 6 * 5 + 3), turn);
}

void StandingEstimator::turn_base(const Vector3& turn) noexcept {
  const Vector3 rates = base_rates(turn);
  for (std::size_t i = 0; i < 3; ++i) position_[3 + i] += rates[i];
}

// Of the base, from the turn rates of the unit, or from feet that stand still; sets the velocities of its joints.
Vector3 StandingEstimator::turn_rate() noexcept {
  Vector3 wanted{};
  const auto without_base = [&](const std::vector<double>& jacobian, std::size_t row) {
    double sum = 0;
    for (std::size_t i = base_joints; i < joints_; ++i) sum += jacobian[row * joints_ + i] * velocity_[i];
    return sum;
  };
  if (state_.imu_counts) {
    (void)dynamics_.link_jacobian(imu_link_, jacobian_);
    double pose[16];
    (void)dynamics_.base_from_link(imu_link_, pose);
    wanted = rotate(pose, rotate(link_from_imu_.data(), heard_.angular_velocity));
    for (std::size_t axis = 0; axis < 3; ++axis) wanted[axis] -= without_base(jacobian_, 3 + axis);
  } else {
    for (const FootPlace& foot : feet_)
      for (std::size_t axis = 0; axis < 3; ++axis) wanted[axis] -= foot.share * without_base(foot.jacobian, 3 + axis);
  }
  std::ranges::copy(base_rates(wanted), velocity_.begin() + 3);
  return wanted;
}

// Turn, in the world, from the estimated tilt to the one that unit or legs tell.
Vector3 StandingEstimator::tilt_error() const noexcept {
  constexpr Vector3 up = {0, 0, 1};
  if (state_.imu_counts) {
    double pose[16];
    (void)dynamics_.base_from_link(imu_link_, pose);
    const auto& m = heard_.up_from_sensor;
    return cross(rotate(pose, rotate(link_from_imu_.data(), {m[6], m[7], m[8]})), up);
  }
  Vector3 error{};
  for (const FootPlace& foot : feet_) error = error + foot.share * cross(rotate(foot.pose.data(), up), up);
  return error;
}

void StandingEstimator::find_feet() noexcept {
  for (FootPlace& foot : feet_) {
    (void)dynamics_.base_from_link(foot.link, foot.pose);
    (void)dynamics_.link_jacobian(foot.link, foot.jacobian);
    foot.place = robotskin::place(foot.pose.data(), foot.sole);
  }
}

// The soles stand on the floor, the origin between them, and face along x.
void StandingEstimator::begin() noexcept {
  std::fill_n(position_.begin(), base_joints, 0.0);
  std::fill_n(velocity_.begin(), base_joints, 0.0);
  for (int pass = 0; pass < 20; ++pass) {
    (void)dynamics_.update(position_, velocity_);
    find_feet();
    const Vector3 error = tilt_error();
    double heading = 0;
    for (const FootPlace& foot : feet_) heading += 0.5 * std::atan2(foot.pose[4], foot.pose[0]);
    turn_base({error[0], error[1], -heading});
    for (std::size_t axis = 0; axis < 3; ++axis) position_[axis] -= 0.5 * (feet_[0].place[axis] + feet_[1].place[axis]);
  }
  (void)dynamics_.update(position_, velocity_);
  find_feet();
  std::array<Vector2, SupportPolygon::most> corners{};
  for (std::size_t i = 0; i < 2; ++i) {
    FootPlace& foot = feet_[i];
    foot.anchor = {foot.place[0], foot.place[1], 0};
    foot.heading = std::atan2(foot.pose[4], foot.pose[0]);
    state_.foot_place[i] = {foot.anchor[0], foot.anchor[1]};
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const double x = (corner < 2 ? 1 : -1) * foot.half[0], y = (corner % 2 == 0 ? 1 : -1) * foot.half[1];
      corners[4 * i + corner] = {foot.anchor[0] + std::cos(foot.heading) * x - std::sin(foot.heading) * y,
                                 foot.anchor[1] + std::sin(foot.heading) * x + std::cos(foot.heading) * y};
    }
  }
  state_.support.set(corners);
  state_.com_velocity = {};
  zmp_began_ = false;
  began_ = true;
}

void StandingEstimator::hear_forces(const SensorReadings& sensors, std::int64_t now_ns, double period_s) noexcept {
  state_.forces_count = true;
  std::array<Vector3, 2> force{}, moment{};
  for (std::size_t i = 0; i < 2; ++i) {
    const FootPlace& foot = feet_[i];
    const auto index = static_cast<std::size_t>(foot.sensor);
    const bool heard = foot.sensor != none && index < sensors.forces.size() &&
                       young(sensors.forces[index].stamp_ns, now_ns, silent_ns) &&
                       finite(sensors.forces[index].force) && finite(sensors.forces[index].moment);
    if (!heard) {
      state_.forces_count = false;
      continue;
    }
    force[i] = sensors.forces[index].force;
    moment[i] = sensors.forces[index].moment;
  }
  double all = 0;
  for (std::size_t i = 0; i < 2; ++i) all += std::max(force[i][2], 0.0);
  if (!state_.forces_count || all < least_load_n) {
    state_.forces_count = false;
    zmp_began_ = false;
    for (FootPlace& foot : feet_) foot.share = 0.5;
    return;
  }
  state_.load_n = all;
  Vector2 zmp{};
  for (std::size_t i = 0; i < 2; ++i) {
    FootPlace& foot = feet_[i];
    state_.foot_load_n[i] = std::max(force[i][2], 0.0);
    foot.share = state_.foot_load_n[i] / all;
    if (state_.foot_load_n[i] < least_share_n) {
      state_.foot_pressure[i] = {};
      continue;
    }
    // The moment about the link's origin is that of a force through a point of the sole's face.
    const Vector3& f = force[i];
    const Vector3& m = moment[i];
    const double z = foot.sole[2];
    const Vector3 point = {(f[0] * z - m[1]) / f[2], (m[0] + f[1] * z) / f[2], z};
    for (std::size_t axis = 0; axis < 2; ++axis)
      state_.foot_pressure[i][axis] =
          std::clamp(point[axis] - foot.sole[axis], -1.2 * foot.half[axis], 1.2 * foot.half[axis]);
    const double c = std::cos(foot.heading), s = std::sin(foot.heading);
    const Vector2 local = state_.foot_pressure[i];
    zmp[0] += foot.share * (foot.anchor[0] + c * local[0] - s * local[1]);
    zmp[1] += foot.share * (foot.anchor[1] + s * local[0] + c * local[1]);
  }
  const double share = zmp_began_ ? low_pass_share(zmp_hz, period_s) : 1;
  zmp_began_ = true;
  for (std::size_t axis = 0; axis < 2; ++axis) state_.zmp[axis] += share * (zmp[axis] - state_.zmp[axis]);
}

bool StandingEstimator::update(const SensorReadings& sensors, std::int64_t now_ns, double period_s,
                               JointState& joints) noexcept {
  if (joints.position.size() != joints_ || joints.velocity.size() != joints_) return false;
  for (std::size_t i = base_joints; i < joints_; ++i)
    if (!std::isfinite(joints.position[i]) || !std::isfinite(joints.velocity[i])) return false;
  std::copy(joints.position.begin() + base_joints, joints.position.end(), position_.begin() + base_joints);
  std::copy(joints.velocity.begin() + base_joints, joints.velocity.end(), velocity_.begin() + base_joints);
  state_.imu_counts = hear_imu(sensors, now_ns);
  if (!began_) begin();

  (void)dynamics_.update(position_, velocity_);
  find_feet();
  hear_forces(sensors, now_ns, period_s);
  const Vector3 rate = turn_rate();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    velocity_[axis] = 0;
    for (const FootPlace& foot : feet_)
      for (std::size_t i = 3; i < joints_; ++i)
        velocity_[axis] -= foot.share * foot.jacobian[axis * joints_ + i] * velocity_[i];
  }

  // The soles stay where they are.
  Vector3 shift{};
  double heading = 0;
  for (const FootPlace& foot : feet_) {
    shift = shift + foot.share * (foot.anchor - foot.place);
    heading += foot.share * (foot.heading - std::atan2(foot.pose[4], foot.pose[0]));
  }
  for (std::size_t axis = 0; axis < 3; ++axis) position_[axis] += shift[axis];
  state_.centre_of_mass = dynamics_.centre_of_mass() + shift;
  (void)dynamics_.centre_of_mass_jacobian(com_jacobian_);
  const double share = low_pass_share(velocity_hz, period_s);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double speed = 0;
    for (std::size_t i = 0; i < joints_; ++i) speed += com_jacobian_[axis * joints_ + i] * velocity_[i];
    state_.com_velocity[axis] += share * (speed - state_.com_velocity[axis]);
  }
  std::copy_n(position_.begin(), base_joints, joints.position.begin());
  std::copy_n(velocity_.begin(), base_joints, joints.velocity.begin());

  // Of the next tick.
  const Vector3 error = tilt_error();
  const double slow = period_s / tilt_s;
  turn_base({period_s * rate[0] + slow * error[0], period_s * rate[1] + slow * error[1],
             period_s * rate[2] + period_s / heading_s * heading});
  return true;
}

}  // namespace robotskin::control
