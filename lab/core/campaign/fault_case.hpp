// SPDX-License-Identifier: Apache-2.0
// One case of the campaign: a skin, its section units, its lines and clocks, and what strikes it when. All from a seed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "campaign/shape.hpp"
#include "world/network/fault_type.hpp"
#include "world/network/network.hpp"

namespace robotskin::campaign {

// A limb's six sums of 15 bits have a bit for each of so many cells.
inline constexpr std::size_t cells_per_limb = 15 * RS_JOINTS_PER_PART;

// A frame may take so many hops that a few more, on the way round a fault, are left of its 63.
inline constexpr std::int32_t hops_max = 40;

// What the cells send.
struct Workload {
  bool events = false;               // of what changes, instead of every sample
  std::int32_t touched_percent = 0;  // of the cells at a time, in event mode
  std::int32_t events_hz = 250;      // so often cells look for a change, in event mode
  std::int32_t limbs = 0;            // whose torques are summed, 0 to 4; 0: none
  bool orders = false;               // the host sends commands and joint positions down
  bool touch = false;                // cells compute their own torques; one limb, with orders and without `limbs`

  bool operator==(const Workload&) const = default;
};

struct FaultCase {
  std::uint64_t seed = 0;
  Shape shape = Shape::sheet;
  bool keyed = false;          // ticks and commands carry tags
  bool whole_lines = true;     // no frame is lost or damaged by chance
  bool while_forming = false;  // the first fault strikes before the network has formed
  Workload workload;
  world::Wiring wiring;
  world::NetworkOptions options;     // without the faults
  std::vector<world::Fault> faults;  // in order of time
  std::int64_t duration_ns = 0;

  std::size_t ports() const;  // cables plugged in
  std::string text() const;   // one line
};

// When the last fault has had its last effect.
std::int64_t end_of(const std::vector<world::Fault>& faults);

// The firmware's settings under which cells send so; none: as they are by default.
std::optional<rs_settings> settings_of(const Workload& workload);

// 20 to 400 cells at most 40 hops from 2 to 5 ports on 1 to 3 section units, 1 to 4 faults of the whole
// catalogue, and at least 300 ms after the last of them. Their processors have 48 MHz and one flash wait state, or take
// no time.
FaultCase draw_case(std::uint64_t seed, bool ideal_processors = false);

// The same case with fewer faults (bit i of `faults` keeps the i-th) or fewer cells (`cells`: which stay; a wire, port
// or fault of one that goes, goes with it).
FaultCase with_faults(const FaultCase& original, const std::vector<bool>& faults);
FaultCase with_cells(const FaultCase& original, const std::vector<bool>& cells);

}  // namespace robotskin::campaign
