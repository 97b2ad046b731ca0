// SPDX-License-Identifier: Apache-2.0
// What a robot may measure beside its joints: inertial units, forces at its feet or hands.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "model/joint_state.hpp"
#include "model/spatial.hpp"

namespace robotskin {

inline constexpr double not_measured = std::numeric_limits<double>::quiet_NaN();
inline constexpr Vector3 vector_not_measured = {not_measured, not_measured, not_measured};

// Where a sensor is.
struct SensorPlace {
  std::string name;
  std::string link;
  std::array<double, 16> link_from_sensor{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};  // row-major, metres
};

// Which sensors a robot has; constant.
struct PortSensors {
  std::vector<SensorPlace> imus;
  std::vector<SensorPlace> forces;
};

// What is absent is absent: `not_measured`, with a stamp of never_ns, and never zero. A reading keeps its last values
// and their stamp; its age tells whether it counts.
struct ImuReading {
  Vector3 acceleration = vector_not_measured;      // m/s^2, specific force, sensor frame
  Vector3 angular_velocity = vector_not_measured;  // rad/s, sensor frame
  // Where the unit estimates it: rotates from the sensor's frame to one whose z points up.
  Matrix3 up_from_sensor = {not_measured, not_measured, not_measured, not_measured, not_measured,
                            not_measured, not_measured, not_measured, not_measured};
  std::int64_t stamp_ns = never_ns;
};

struct ForceReading {
  Vector3 force = vector_not_measured;   // newton, what acts on the robot, sensor frame
  Vector3 moment = vector_not_measured;  // Nm about the sensor's origin; not measured by one of force alone
  std::int64_t stamp_ns = never_ns;
};

// One entry a sensor, in the order of PortSensors.
struct SensorReadings {
  SensorReadings() = default;
  explicit SensorReadings(const PortSensors& sensors) : imus(sensors.imus.size()), forces(sensors.forces.size()) {}

  std::vector<ImuReading> imus;
  std::vector<ForceReading> forces;
};

}  // namespace robotskin
