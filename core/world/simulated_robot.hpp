// SPDX-License-Identifier: Apache-2.0
// A robot that exists in MuJoCo only, behind the same port as a real one.
#pragma once

#include <vector>

#include "model/robot_port.hpp"
#include "world/imperfections.hpp"
#include "world/robot_sensors.hpp"

struct mjModel_;
struct mjData_;

namespace robotskin::world {

// Inner loops of an industrial controller: a position or velocity command is tracked by torques that carry the arm's
// own weight and damping D and are scaled by how it answers: tau = C v + g + D v + (M + D h) (kp e + kd de/dt + ki
// integral e), with a short time h.
struct ServoGains {
  double stiffness = 16000;  // kp, 1/s^2
  double damping = 220;      // kd, 1/s
  double integral = 60000;   // ki, 1/s^3
};

// Not for several threads at once: the thread that steps the world also calls the port.
class SimulatedRobot : public RobotPort {
 public:
  // `joints`: MuJoCo joint of each of the n robot joints; effort_limit (n) Nm or N. The first `base_joints` of them
  // move a base that nothing drives or measures: they are NaN in what is read, and their part of a command is not
  // looked at. Such a robot takes positions alone.
  SimulatedRobot(const mjModel_& model, const mjData_& data, const std::vector<int>& joints,
                 std::vector<double> effort_limit, const ServoGains& gains, const Imperfections& imperfections,
                 SensorMounting sensors = {}, std::size_t base_joints = 0, std::uint64_t seed = 1);

  std::size_t joint_count() const noexcept override { return position_address_.size(); }
  bool offers(CommandMode mode) const noexcept override;
  bool offers_by_joint() const noexcept override { return base_joints_ == 0; }
  PortSensors sensors() const override { return sensors_.places(); }
  [[nodiscard]] PortStatus read(JointState& state) noexcept override;
  [[nodiscard]] PortStatus read_sensors(SensorReadings& readings) noexcept override;
  [[nodiscard]] PortStatus write(const JointCommand& command) noexcept override;
  void stop() noexcept override;

  // Between the two halves of a physics step: sets the joints' torques.
  void drive(const mjModel_& model, mjData_& data) noexcept;
  // After a physics step: `stamp_ns` becomes the stamp of the next state read, which is as old as the encoders are
  // late.
  void measure(const mjModel_& model, const mjData_& data, std::int64_t stamp_ns) noexcept;

  // (n) where each joint's position stands in qpos.
  const std::vector<int>& position_address() const { return position_address_; }

 private:
  void brake(const mjData_& data, double step_s) noexcept;
  void measure_joints(const mjData_& data, std::int64_t stamp_ns) noexcept;

  std::vector<int> position_address_, velocity_address_;
  std::vector<double> effort_limit_;
  ServoGains gains_;
  JointCommand command_;
  std::vector<double> goal_;             // (n) position the servo holds or, in velocity mode, moves along
  std::vector<double> error_sum_;        // (n) integral of the position error
  std::vector<double> wanted_, torque_;  // (nv) of the whole MuJoCo model
  JointState measured_;
  // Encoders: position in steps; velocity comes from the motors' side of the gears, a hundred times finer.
  double encoder_step_ = 0;             // rad or m, 0: none
  std::vector<double> late_;            // (delay, 2 n) positions and velocities not yet told, as a ring
  std::size_t delay_ = 0, oldest_ = 0;  // in physics steps; row of the ring
  double braking_s_ = 0;                // left of the time in which a stop may brake
  double command_left_s_ = -1;          // of the life of the last command; negative: stopped
  bool unread_ = false, sensors_unread_ = false;
  RobotSensors sensors_;
  std::size_t base_joints_;
};

}  // namespace robotskin::world
