// SPDX-License-Identifier: Apache-2.0
// Where the base of a standing robot is: from its joints, its inertial unit and the feet that stand still.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "control/standing_state.hpp"
#include "model/foot.hpp"
#include "model/joint_state.hpp"
#include "model/robot_dynamics.hpp"
#include "model/sensor_readings.hpp"

namespace robotskin::control {

// The tilt follows the turn rates and, slowly, the unit's own orientation, of which only `up` is used. Place and
// heading come from the soles: they stay where they stood at the beginning, each as far as it carries the robot. What
// is lost is done without: a unit that is silent or stuck by legs on level ground, forces by feet that carry alike.
class StandingEstimator {
 public:
  // The robot's first six joints move its base: x, y, z, yaw, pitch and roll. Throws ControlError for another robot, or
  // unless there are two feet; ModelError for a link that the robot does not have.
  StandingEstimator(const RobotModel& robot, const std::vector<Foot>& feet);

  // Which of the port's sensors are used: the first inertial unit, and the force sensor of each foot's link.
  void use_sensors(const RobotModel& robot, const PortSensors& sensors);
  void restart() noexcept { began_ = false; }

  // Fills the six joints of the base in. False, with nothing changed, if the other joints are not finite. Allocates
  // nothing.
  [[nodiscard]] bool update(const SensorReadings& sensors, std::int64_t now_ns, double period_s,
                            JointState& joints) noexcept;

  const StandingState& state() const noexcept { return state_; }

  static constexpr std::size_t base_joints = 6;

 private:
  static constexpr int none = -1;

  struct FootPlace {
    std::size_t link;
    Vector3 sole;
    std::array<double, 2> half;
    int sensor = none;
    std::array<double, 16> pose{};  // world from link, of this tick
    Vector3 place{};                // of the sole's middle
    Vector3 anchor{};               // where it stands
    double heading = 0;
    double share = 0.5;            // of the robot that it carries
    std::vector<double> jacobian;  // (6, n) of the link
  };

  bool hear_imu(const SensorReadings& sensors, std::int64_t now_ns) noexcept;
  void hear_forces(const SensorReadings& sensors, std::int64_t now_ns, double period_s) noexcept;
  void begin() noexcept;
  Vector3 base_rates(const Vector3& turn) const noexcept;
  void turn_base(const Vector3& turn) noexcept;
  Vector3 turn_rate() noexcept;
  Vector3 tilt_error() const noexcept;
  void find_feet() noexcept;

  RobotDynamics dynamics_;
  std::size_t joints_;
  std::array<FootPlace, 2> feet_;
  int imu_ = none;
  std::size_t imu_link_ = 0;
  std::array<double, 16> link_from_imu_{};
  ImuReading heard_;
  std::int64_t imu_changed_ns_ = never_ns;
  std::vector<double> position_, velocity_, jacobian_, com_jacobian_;
  StandingState state_;
  bool began_ = false, zmp_began_ = false;
};

}  // namespace robotskin::control
