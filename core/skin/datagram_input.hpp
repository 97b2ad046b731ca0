// SPDX-License-Identifier: Apache-2.0
// The samples of our own cells: what the driver has taken from datagrams, as the input of a loop.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "driver/driver.hpp"
#include "skin/skin_input.hpp"
#include "skin/skin_reader.hpp"
#include "skin/torque_reader.hpp"

namespace robotskin::skin {

// How a joint's position is told to the cells of a limb.
struct JointCode {
  enum class Kind : std::uint8_t { turn, slide, none };  // none: told as 0, the cells do not need it
  std::size_t joint = 0;                                 // of the robot
  Kind kind = Kind::turn;
};

struct LimbCodes {
  std::uint16_t group = 0;
  std::uint8_t limb = 0;
  std::vector<JointCode> joints;  // in the order of its vector
};

// Reads beside the driver's thread, or between its polls; it belongs to one thread.
class DatagramInput final : public SkinInput {
 public:
  // Keeps the reader, which must outlive it.
  explicit DatagramInput(SkinReader& reader) noexcept : reader_(reader) {}

  // From then on the cells hear where the joints are, and what they compute is read. Not while the loop runs. Throws
  // std::invalid_argument for a limb with a joint that there is not.
  void take_skin_computed_torque(driver::Driver& driver, TorqueReader& torques, std::vector<LimbCodes> limbs,
                                 std::size_t joint_count);
  // False: the cells are told no more, and what they said last grows old. From the loop's thread.
  void tell(bool on) noexcept { telling_ = on; }

  std::size_t cell_count() const noexcept override { return reader_.cell_count(); }
  [[nodiscard]] InputStatus read(std::int64_t now_ns, SkinState& state) noexcept override;
  std::int64_t fresh_ns() const noexcept override { return reader_.longest_fresh_ns(); }
  void tell_joints(std::int64_t now_ns, std::span<const double> position) noexcept override;
  const SkinTorque* skin_computed_torque() const noexcept override {
    return torques_ == nullptr ? nullptr : &skin_computed_torque_;
  }

 private:
  SkinReader& reader_;
  driver::Driver* driver_ = nullptr;
  TorqueReader* torques_ = nullptr;
  std::vector<LimbCodes> limbs_;
  SkinTorque skin_computed_torque_;
  bool telling_ = true;
};

}  // namespace robotskin::skin
