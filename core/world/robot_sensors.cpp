// SPDX-License-Identifier: Apache-2.0
#include "world/robot_sensors.hpp"

#include <mujoco/mujoco.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "world/random.hpp"

namespace robotskin::world {
namespace {

constexpr std::uint64_t purpose = 0x1A0;
constexpr double degree = std::numbers::pi / 180;
constexpr double wander_s = 2;  // time in which a tilt error forgets what it was

std::size_t steps(double seconds, double step_s) {
  return static_cast<std::size_t>(std::llround(seconds / step_s));
}

}  // namespace

RobotSensors::RobotSensors(const mjModel& model, SensorMounting mounting, const Imperfections& imperfections,
                           std::uint64_t seed)
    : mounting_(std::move(mounting)),
      readings_(mounting_.sensors),
      tilt_rad_(imperfections.imu_tilt_deg * degree),
      wander_share_(model.opt.timestep / wander_s),
      rate_noise_rad_s_(imperfections.imu_rate_noise_rad_s),
      force_noise_n_(imperfections.robot_force_noise_n),
      moment_noise_nm_(imperfections.robot_moment_noise_nm),
      force_share_(
          imperfections.robot_force_bandwidth_hz > 0
              ? 1 - std::exp(-2 * std::numbers::pi * imperfections.robot_force_bandwidth_hz * model.opt.timestep)
              : 1.0),
      wander_(mounting_.imu_body.size()),
      filtered_(mounting_.force_body.size()),
      late_imus_(steps(imperfections.imu_delay_s, model.opt.timestep), mounting_.imu_body.size()),
      late_forces_(steps(imperfections.robot_force_delay_s, model.opt.timestep), mounting_.force_body.size()),
      noise_key_(stream_key(seed, purpose, 0)) {
  const std::uint64_t key = stream_key(seed, purpose, 1);
  std::uint64_t draw = 0;
  const auto drawn = [&](double width) { return random_symmetric(key, draw++, width); };
  for (std::size_t i = 0; i < mounting_.imu_body.size(); ++i) {
    const double tilt = imperfections.imu_bias_deg * degree;
    bias_.push_back({drawn(tilt), drawn(tilt), drawn(tilt > 0 ? std::numbers::pi : 0)});
  }
  for (std::size_t i = 0; i < mounting_.force_body.size(); ++i) {
    const double force = imperfections.robot_force_bias_n, moment = imperfections.robot_moment_bias_nm;
    force_bias_.push_back({drawn(force), drawn(force), drawn(force)});
    moment_bias_.push_back({drawn(moment), drawn(moment), drawn(moment)});
    filtered_[i].force = filtered_[i].moment = {0, 0, 0};
  }
  for (std::size_t i = 0; i < mounting_.imu_body.size(); ++i) {
    const double rate = imperfections.imu_rate_bias_rad_s;
    rate_bias_.push_back({drawn(rate), drawn(rate), drawn(rate)});
  }
}

double RobotSensors::noise() noexcept {
  return normal_quantiles()[random_bits(noise_key_, draws_++) >> (64 - normal_bits)];
}

void RobotSensors::measure(const mjModel& model, const mjData& data, std::int64_t stamp_ns) noexcept {
  for (std::size_t i = 0; i < mounting_.imu_body.size(); ++i) {
    ImuReading reading = imu(model, data, i);
    reading.stamp_ns = stamp_ns;
    late_imus_.exchange(reading, i);
    if (reading.stamp_ns != never_ns) readings_.imus[i] = reading;
  }
  late_imus_.advance();
  for (std::size_t i = 0; i < mounting_.force_body.size(); ++i) {
    force(model, data, i);
    ForceReading reading;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      reading.force[axis] = filtered_[i].force[axis] + force_bias_[i][axis] + force_noise_n_ * noise();
      reading.moment[axis] = filtered_[i].moment[axis] + moment_bias_[i][axis] + moment_noise_nm_ * noise();
    }
    reading.stamp_ns = stamp_ns;
    late_forces_.exchange(reading, i);
    if (reading.stamp_ns != never_ns) readings_.forces[i] = reading;
  }
  late_forces_.advance();
  began_ = true;
}

ImuReading RobotSensors::imu(const mjModel& model, const mjData& data, std::size_t index) noexcept {
  const int body = mounting_.imu_body[index];
  // Slow: its spread stays tilt_rad_, whatever the step.
  for (double& angle : wander_[index])
    angle += -wander_share_ * angle + tilt_rad_ * std::sqrt(2 * wander_share_) * noise();
  const Vector3 error = bias_[index] + Vector3{wander_[index][0], wander_[index][1], 0};
  const Matrix3 heading = rotation_about({0, 0, error[2]});
  const Matrix3 tilt = rotation_about({error[0], error[1], 0});
  ImuReading reading;
  reading.up_from_sensor = multiply(heading, multiply(tilt, load9(data.xmat + 9 * body)));
  mjtNum spatial[6];
  mj_objectVelocity(&model, &data, mjOBJ_BODY, body, spatial, 1);
  reading.angular_velocity = load3(spatial);
  mj_objectAcceleration(&model, &data, mjOBJ_BODY, body, spatial, 1);
  reading.acceleration = load3(spatial + 3);
  for (std::size_t axis = 0; axis < 3; ++axis)
    reading.angular_velocity[axis] += rate_bias_[index][axis] + rate_noise_rad_s_ * noise();
  return reading;
}

void RobotSensors::force(const mjModel& model, const mjData& data, std::size_t index) noexcept {
  const int body = mounting_.force_body[index];
  const Vector3 origin = load3(data.xpos + 3 * body);
  Vector3 force = {0, 0, 0}, moment = {0, 0, 0};
  for (int i = 0; i < data.ncon; ++i) {
    const mjContact& contact = data.contact[i];
    if (contact.efc_address < 0 || contact.geom[0] < 0 || contact.geom[1] < 0) continue;
    const bool second = model.geom_bodyid[contact.geom[1]] == body;
    if (!second && model.geom_bodyid[contact.geom[0]] != body) continue;
    mjtNum wrench[6];
    mj_contactForce(&model, &data, i, wrench);
    const auto in_world = [&](const mjtNum* w) {
      const double sign = second ? 1 : -1;  // the wrench is on the second geom
      return sign * (w[0] * load3(contact.frame) + w[1] * load3(contact.frame + 3) + w[2] * load3(contact.frame + 6));
    };
    const Vector3 own = in_world(wrench);
    force = force + own;
    moment = moment + cross(load3(contact.pos) - origin, own) + in_world(wrench + 3);
  }
  const Matrix3 rotation = load9(data.xmat + 9 * body);
  const Vector3 now[2] = {apply_transposed(rotation, force), apply_transposed(rotation, moment)};
  const double share = began_ ? force_share_ : 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    filtered_[index].force[axis] += share * (now[0][axis] - filtered_[index].force[axis]);
    filtered_[index].moment[axis] += share * (now[1][axis] - filtered_[index].moment[axis]);
  }
}

}  // namespace robotskin::world
