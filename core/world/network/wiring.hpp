// SPDX-License-Identifier: Apache-2.0
// Which port is plugged into which, and how good the wires and the clocks are.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace robotskin::world {

// One end of a wire. For cells ports are 1 to 4, for section units 1 to 15.
struct CellEnd {
  std::int32_t cell = -1;  // -1: nothing there
  std::uint8_t port = 0;
};

struct UnitDescription {
  std::uint16_t group = 0;     // the name space of cell ids
  std::uint8_t unit = 0;       // within the group
  std::vector<CellEnd> ports;  // the cell at port p at index p - 1; at most 15
  std::int64_t skew_ns = 0;    // of its clock against virtual time, at the start
  double drift_ppm = 0;
};

struct Wiring {
  std::vector<std::array<CellEnd, 4>> neighbours;  // (N) by own port - 1; a wire that only one side names is no wire
  std::vector<std::uint16_t> id;                   // (N) kept in the cells' flash; 0: named by the network
  std::vector<UnitDescription> units;              // (U)

  std::size_t cell_count() const { return neighbours.size(); }
};

// Shares are of frames, drift is of each cell's own clock. Every wire draws its faults from the run's seed.
struct LineQuality {
  double jitter_us = 1;             // a frame takes up to this much longer than its 50 us
  double lost_share = 0;            // frames that vanish
  double bit_error_rate = 0;        // bits that flip before the checksum is seen
  double clock_drift_ppm = 100;     // drawn evenly within +-
  double power_up_spread_us = 500;  // cells start within this time after they get power
  double unit_skew_us = 0;          // section units' clocks at the start, drawn evenly within +-
  double unit_drift_ppm = 0;        // and how fast they go, within +-
};

}  // namespace robotskin::world
