// SPDX-License-Identifier: Apache-2.0
// From the limbs' vectors of the driver to joint torques: what the cells have computed themselves, in SI units.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "driver/snapshot_table.hpp"
#include "driver/torque_table.hpp"

namespace robotskin::skin {

// What the skin asks of the joints in one control cycle, as its own cells have computed it.
struct SkinTorque {
  std::vector<double> joint;            // (n) Nm, N where a joint slides, in the order of the robot's joints
  std::int64_t stamp_ns = 0;            // host clock when the oldest of the limbs' epochs began
  std::uint32_t cells = 0, active = 0;  // summed, and in contact
  bool fresh = false;                   // every limb has said something new; else `joint` is zero
  bool saturated = false;               // a sum has left its range

  explicit SkinTorque(std::size_t joints = 0) : joint(joints) {}
};

// A limb's joints in the order of its vector, as indices of the robot's.
struct LimbPlace {
  std::uint16_t group = 0;
  std::uint8_t limb = 0;
  std::vector<std::size_t> joints;
};

struct TorqueReaderOptions {
  double step = 1.0 / 256;             // Nm, of the vectors
  std::int64_t fresh_ns = 24'000'000;  // no vector counts whose epoch began earlier
};

// Reads beside the driver's thread; each reader belongs to one thread, and the driver's table to one reader.
class TorqueReader {
 public:
  // Throws std::invalid_argument for a limb with a joint that the robot of n joints does not have, or too many.
  TorqueReader(driver::SnapshotTable<driver::LimbTorque>& torques, std::vector<LimbPlace> limbs, std::size_t joints,
               const TorqueReaderOptions& options);

  // A vector that lacks a part or a section unit is passed over as long as the whole one before it is fresh.
  void read(std::int64_t now_ns, SkinTorque& torque);

 private:
  driver::SnapshotTable<driver::LimbTorque>& torques_;
  std::vector<LimbPlace> limbs_;
  std::vector<driver::LimbTorque> newest_;  // by limb
  std::size_t joints_;
  TorqueReaderOptions options_;
};

}  // namespace robotskin::skin
