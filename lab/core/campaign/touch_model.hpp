// SPDX-License-Identifier: Apache-2.0
// What touch on a cell asks for and means for the joints below it, in double precision: what cells that compute their
// own torques are judged by [Cheng19 eq. 14, 16 and 21].
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "robotskin/cell.h"
#include "world/random.hpp"

namespace robotskin::campaign {

// Of one cell; whole numbers as they stand in its flash.
class TouchModel {
 public:
  static constexpr std::size_t joints_max = RS_JOINTS_PER_PART;
  using Torques = std::array<double, joints_max>;

  // All cells of a limb count in steps of 2^-`step_bits` Nm.
  TouchModel(world::RandomStream& draw, int step_bits);

  // As torque_parameters.h has it, written apart from the firmware.
  std::array<std::uint8_t, RS_TORQUE_IMAGE_BYTES> image() const;
  // N, of counts.
  double force(const rs_sample& sample) const;
  // In steps, by a force in N at joint positions as they are broadcast.
  Torques torques(double force, std::span<const std::int16_t> position) const;
  // By which a cell's whole numbers may be off, steps.
  double tolerance(double force) const;
  std::size_t joints() const { return joints_; }

 private:
  struct Sense {
    std::uint16_t silent, full, weight;
    std::uint8_t weight_bits;

    double asked(double counts) const;
  };
  struct Place {
    std::array<std::int16_t, 9> rotation;
    std::array<std::int16_t, 3> offset;
  };

  std::size_t joints_;
  int step_bits_, length_exponent_;
  std::uint16_t prismatic_, slide_;
  std::array<std::int16_t, 3> point_, direction_;
  std::array<Place, joints_max - 1> place_;  // of joint l + 1
  Sense force_, proximity_;
};

}  // namespace robotskin::campaign
