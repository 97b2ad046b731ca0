// SPDX-License-Identifier: Apache-2.0
// A cell's memory that is overwritten.
#include <cstddef>

#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

struct Range {
  std::size_t first, bytes;
};

// Where a cell keeps what a part names.
std::vector<Range> ranges_of(FaultPart part) {
  constexpr Range route{offsetof(rs_cell, route), sizeof(rs_route)};
  constexpr Range queues{offsetof(rs_cell, queues), sizeof(rs_queues)};
  constexpr Range sampling{offsetof(rs_cell, sampling), sizeof(rs_sampling)};
  switch (part) {
    case FaultPart::route:
      return {route};
    case FaultPart::queues:
      return {queues};
    case FaultPart::sampling:
      return {sampling};
    case FaultPart::arq:
      return {{offsetof(rs_cell, arq_sender), sizeof(rs_arq_sender)}};
    case FaultPart::torque:
      return {{offsetof(rs_cell, torque), offsetof(rs_cell, arq_sender) - offsetof(rs_cell, torque)}};
    case FaultPart::commands:
      return {{offsetof(rs_cell, commanding), sizeof(rs_commanding)}};
    case FaultPart::settings:
      return {{offsetof(rs_cell, settings), offsetof(rs_cell, counts) - offsetof(rs_cell, settings)}};
    case FaultPart::whole:
      return {{0, sizeof(rs_cell)}};
    case FaultPart::all:
      break;
  }
  return {route, queues, sampling};
}

void draw(FaultDraw& draw, Fault& fault) {
  fault.cell = draw.cell();
  fault.count = 1 << draw.below(8);
  fault.part = static_cast<FaultPart>(draw.below(4));
}

void begin(Network::RunningFault& act, int) {
  if (!act.cell_is_on()) return;
  auto* state = reinterpret_cast<std::uint8_t*>(&act.cell().state);
  const std::vector<Range> ranges = ranges_of(act.fault.part);
  std::size_t whole = 0;
  for (const Range& range : ranges) whole += range.bytes;
  RandomStream draw(act.random_key(act.number));
  for (std::int32_t k = 0; k < act.fault.count; ++k) {
    std::size_t at = draw.below(whole);
    const auto* range = ranges.data();
    for (; at >= range->bytes; ++range) at -= range->bytes;
    state[range->first + at] = static_cast<std::uint8_t>(draw.bits());
  }
  act.report_idle_wires();
}

void tell(const Fault& fault, bool, FaultWitness& witness) {
  witness.memory_overwritten(static_cast<std::size_t>(fault.cell));
}

}  // namespace

constinit const FaultType ram{
    .number = 10,
    .name = "ram",
    .keys = "cell! bytes=16 part=route",
    .text = "so many bytes of the cell's state are overwritten",
    .draw = draw,
    .course = FaultCourse::momentary,
    .begin = begin,
    .truth = {.everywhere = true, .overwrites_memory = true},
    .tell = tell,
};

}  // namespace robotskin::world::faults
