// SPDX-License-Identifier: Apache-2.0
// What a simulated robot measures beside its joints: an inertial unit on a link, and the forces on links such as feet.
//
// The unit's orientation is wrong by a bias and a slow wandering of its tilt, and its heading is of no use: it begins
// anywhere. Its turn rates have a bias, too. A force sensor sums what presses its link from outside, and is slow, noisy
// and biased. All of it is told late.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "model/sensor_readings.hpp"
#include "world/imperfections.hpp"

struct mjModel_;
struct mjData_;

namespace robotskin::world {

// Names of the sensors and the MuJoCo bodies that carry them, in the same order.
struct SensorMounting {
  PortSensors sensors;
  std::vector<int> imu_body, force_body;
};

// Readings of some sensors, told whole steps later. The first ones are those of a new `Reading`.
template <class Reading>
class LateReadings {
 public:
  LateReadings(std::size_t steps, std::size_t sensors) : steps_(steps), sensors_(sensors), ring_(steps * sensors) {}
  // Keeps what a sensor says now, and gives what it said so many steps ago.
  void exchange(Reading& reading, std::size_t sensor) noexcept {
    if (steps_ > 0) std::swap(reading, ring_[oldest_ * sensors_ + sensor]);
  }
  void advance() noexcept {
    if (steps_ > 0) oldest_ = (oldest_ + 1) % steps_;
  }

 private:
  std::size_t steps_, sensors_, oldest_ = 0;
  std::vector<Reading> ring_;  // (steps, sensors)
};

class RobotSensors {
 public:
  RobotSensors(const mjModel_& model, SensorMounting mounting, const Imperfections& imperfections, std::uint64_t seed);

  const PortSensors& places() const { return mounting_.sensors; }
  // Reads the last physics step. Allocates nothing.
  void measure(const mjModel_& model, const mjData_& data, std::int64_t stamp_ns) noexcept;
  const SensorReadings& readings() const { return readings_; }

 private:
  double noise() noexcept;
  ImuReading imu(const mjModel_& model, const mjData_& data, std::size_t index) noexcept;
  void force(const mjModel_& model, const mjData_& data, std::size_t index) noexcept;

  SensorMounting mounting_;
  SensorReadings readings_;
  double tilt_rad_, wander_share_, rate_noise_rad_s_, force_noise_n_, moment_noise_nm_, force_share_;
  std::vector<Vector3> bias_;                      // of each unit, rad: tilt about x and y, heading
  std::vector<Vector3> rate_bias_;                 // of each unit, rad/s
  std::vector<Vector3> wander_;                    // of each unit, rad
  std::vector<Vector3> force_bias_, moment_bias_;  // of each force sensor
  std::vector<ForceReading> filtered_;             // of each force sensor, before noise and bias
  LateReadings<ImuReading> late_imus_;
  LateReadings<ForceReading> late_forces_;
  std::uint64_t noise_key_, draws_ = 0;
  bool began_ = false;
};

}  // namespace robotskin::world
