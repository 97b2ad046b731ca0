// SPDX-License-Identifier: Apache-2.0
// What a cell's processor adds to the times that the checkers allow, by the table of its cycles.
#pragma once

#include <algorithm>
#include <cstdint>

#include "robotskin/section_unit.h"
#include "robotskin/timing.h"
#include "world/network/processor.hpp"

namespace robotskin::campaign {

struct ProcessingTimes {
  explicit ProcessingTimes(world::Processor processor)
      : tick_ns(world::processing_ns(processor, world::InputKind::wave, RS_PORTS)),
        status_ns(world::processing_ns(processor, world::InputKind::status, 1)),
        sum_ns(world::processing_ns(processor, world::InputKind::torque, 1)),
        longest_ns(longest(processor)),
        catch_up_ns(catch_up(processor)) {}

  std::int64_t tick_ns;      // a new tick, told to all neighbours
  std::int64_t status_ns;    // a size, told to the parent
  std::int64_t sum_ns;       // a torque sum, passed on
  std::int64_t longest_ns;   // of all inputs of a cell that runs
  std::int64_t catch_up_ns;  // from a repair until the cell at a cable has nothing left of what that costs

 private:
  static std::int64_t longest(world::Processor processor) {
    std::int64_t longest_ns = 0;
    for (std::size_t kind = 0; kind < world::input_kind_names.size(); ++kind)
      if (static_cast<world::InputKind>(kind) != world::InputKind::boot)
        longest_ns =
            std::max(longest_ns, world::processing_ns(processor, static_cast<world::InputKind>(kind), RS_PORTS));
    return longest_ns;
  }

  // Of each cell of a full cable: the request for an id and the answer to it, its size, its neighbours, a torque sum
  // that no parent waits for yet, and the samples that it kept while it had no way. What goes on all the time leaves
  // two fifths of the processor for that (docs/firmware_on_a_chip.md: the budget with one wait state).
  static std::int64_t catch_up(world::Processor processor) {
    using Kind = world::InputKind;
    constexpr std::int64_t kept = RS_ORPHAN_KEEP_US * RS_CLOCK_RATE_DEFAULT_HZ / 1'000'000;
    std::int64_t cell_ns = kept * world::processing_ns(processor, Kind::clock, 1);
    for (const Kind kind : {Kind::join, Kind::command, Kind::status, Kind::topology, Kind::torque})
      cell_ns += world::processing_ns(processor, kind, 1);
    return RS_CELLS_PER_PORT * cell_ns * 5 / 2;
  }
};

}  // namespace robotskin::campaign
