// SPDX-License-Identifier: Apache-2.0
// The simulated body: one MuJoCo model with robot, cells, hands and objects, and what the cells' sensors feel of it.
//
// Each physics step: what moves on a path takes its place, then kinematics and how stiff each contact is, then the
// torques of robot and hands, then dynamics; after it contacts, motion and temperatures are read. What is true at the
// step's start is held until the next step: a cell that samples at any virtual time in between reads that.
#pragma once

#include <cstdint>
#include <vector>

#include "world/accelerometer.hpp"
#include "world/carrier.hpp"
#include "world/contact.hpp"
#include "world/contact_law.hpp"
#include "world/hand.hpp"
#include "world/mounting.hpp"
#include "world/proximity.hpp"
#include "world/sensors.hpp"
#include "world/simulated_robot.hpp"
#include "world/temperature.hpp"

namespace robotskin::world {

class Body {
 public:
  // Model and data are shared with Python, which keeps them alive; they are the only physics.
  Body(mjModel_* model, mjData_* data, Mounting mounting, const std::vector<HandDescription>& hands,
       std::vector<Carrier> carriers, const std::vector<int>& robot_joints, const std::vector<double>& effort_limit,
       const ServoGains& gains, const Imperfections& imperfections, std::uint64_t seed, SensorMounting sensors = {},
       std::size_t base_joints = 0);

  // One physics step from `time_ns` of the simulated clock on.
  void step(std::int64_t time_ns);
  double timestep_s() const;

  // The reading of a cell; true if a channel is at the end of its range. Between two steps several threads may read,
  // each its own cells.
  bool sample(std::size_t cell, std::int64_t time_ns, rs_sample& sample);
  // Without the distance, which takes longest, it is 0.
  Truth truth(std::size_t cell, std::int64_t time_ns, bool with_distance = true) const;

  // What is wrong with a cell's sensors from now on. Throws std::out_of_range for no cell.
  void set_sensor_fault(std::size_t cell, const SensorFault& fault) { sensors_.set_fault(cell, fault); }
  // Two cells are found in each other's place, as if they had been mixed up when the skin was mended.
  void swap_cells(std::size_t one, std::size_t other);

  // (4, 4) row-major, as of the last physics step.
  std::array<double, 16> world_from_cell(std::size_t cell) const;

  std::size_t cell_count() const { return mounting_.cell_count(); }
  const Mounting& mounting() const { return mounting_; }
  const Contacts& contacts() const { return contacts_; }
  const Sensors& sensors() const { return sensors_; }
  SimulatedRobot& robot() { return robot_; }
  std::vector<Hand>& hands() { return hands_; }
  std::vector<Carrier>& carriers() { return carriers_; }

 private:
  Truth truth(std::size_t cell, double time_s, const Seen& seen) const;

  mjModel_* model_;
  mjData_* data_;
  Mounting mounting_;
  ContactLaw contact_law_;
  Contacts contacts_;
  Accelerometer accelerometer_;
  Proximity proximity_;
  Temperature temperature_;
  Sensors sensors_;
  SimulatedRobot robot_;
  std::vector<Hand> hands_;
  std::vector<Carrier> carriers_;
  std::vector<std::size_t> place_;  // (N) where on the robot each cell sits; its own place unless swapped
};

}  // namespace robotskin::world
