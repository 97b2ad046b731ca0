// SPDX-License-Identifier: Apache-2.0
// What the host sends to section units: keep-alives, commands to cells, power of ports.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "robotskin/operations.h"
#include "robotskin/wire.h"

namespace robotskin::driver {

// One command to a cell, or to all cells of a group (target 16383). What index and value mean: operations.h.
struct Command {
  std::uint16_t group = 0;
  std::uint16_t target = RS_ID_ALL;
  std::uint8_t operation = 0;
  std::uint16_t index = 0;
  std::uint64_t value = 0;   // 48 bits; signed ones in two's complement of 32
  std::uint32_t ticket = 0;  // filled in by the driver; the reply carries it
};

struct Reply {
  std::int64_t heard_ns = 0;
  std::uint16_t group = 0;
  std::uint16_t source = 0;
  std::uint8_t operation = 0;
  std::uint8_t status = 0;
  std::uint8_t version = 0;  // of the cell's firmware
  std::uint32_t ticket = 0;  // of the command, 0: not one of the last 1024 of this driver
  std::uint16_t index = 0;
  std::uint16_t value_high = 0;  // operation whose value it is
  std::uint32_t value = 0;       // in force now
};

// Where the joints of a limb are, for its cells to compute their torques from.
struct LimbJoints {
  std::int64_t set_ns = 0;  // host clock; 0: this row is not used
  std::uint16_t group = 0;
  std::uint8_t limb = 0;
  std::uint8_t joints = 0;
  std::array<std::int16_t, std::size_t{4} * RS_JOINTS_PER_PART> position{};  // 2 pi / 65536 rad; m with 15 bits
};

// Switches the power of a section unit's port (0: all) on or off.
struct Power {
  std::uint16_t group = 0;
  std::uint8_t unit = 255;  // 255: every unit of the group
  std::uint8_t port = 0;
  bool on = true;
};

// Where a datagram goes: a unit, or 255 for all of the group. `pending`: a unit that has not shown yet that it lives
// now, to be answered where its last datagram came from.
struct Recipient {
  std::uint16_t group = 0;
  std::uint8_t unit = 255;
  bool pending = false;
};

}  // namespace robotskin::driver
