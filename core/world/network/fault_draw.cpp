// SPDX-License-Identifier: Apache-2.0
// Drawing of random faults that fit a wiring.
#include "world/network/fault_draw.hpp"

#include <vector>

#include "robotskin/wire.h"
#include "world/network/fault_type.hpp"

namespace robotskin::world {

namespace {

constexpr std::uint64_t purpose_faults = 31;

}  // namespace

FaultDraw::FaultDraw(const Wiring& wiring, std::uint64_t seed)
    : wiring_(wiring), stream_(stream_key(seed, purpose_faults, 0)) {}

std::int64_t FaultDraw::time_between(std::int64_t low_ns, std::int64_t high_ns) {
  return (low_ns + static_cast<std::int64_t>(below(static_cast<std::uint64_t>(high_ns - low_ns + 1)))) / 10000 * 10000;
}

std::int32_t FaultDraw::port(std::int32_t cell) {
  std::vector<std::int32_t> ports;
  for (std::int32_t p = 1; p <= RS_PORTS; ++p)
    if (wiring_.neighbours[static_cast<std::size_t>(cell)][static_cast<std::size_t>(p) - 1].cell >= 0)
      ports.push_back(p);
  return ports.empty() ? 1 : ports[below(ports.size())];
}

std::int32_t FaultDraw::wired_port(std::int32_t cell) {
  for (const UnitDescription& unit : wiring_.units)
    for (const CellEnd& end : unit.ports)
      if (end.cell == cell && below(4) == 0) return static_cast<std::int32_t>(end.port);
  return port(cell);
}

std::int32_t FaultDraw::unit_port(std::int32_t unit) {
  return 1 + static_cast<std::int32_t>(below(wiring_.units[static_cast<std::size_t>(unit)].ports.size()));
}

void FaultDraw::place(Fault& fault) {
  if (units() > 0 && below(8) == 0) {
    fault.unit = unit();
    fault.port = unit_port(fault.unit);
  } else {
    fault.cell = cell();
    fault.port = port(fault.cell);
  }
}

bool has_units(const Wiring& wiring, std::span<const Fault>) {
  return !wiring.units.empty();
}

bool has_two_units(const Wiring& wiring, std::span<const Fault>) {
  return wiring.units.size() > 1;
}

bool has_two_cells(const Wiring& wiring, std::span<const Fault>) {
  return wiring.cell_count() > 1;
}

std::vector<Fault> draw_faults(const Wiring& wiring, std::int32_t count, std::int64_t from_ns, std::uint64_t seed) {
  constexpr std::int64_t ms = FaultDraw::ms;
  FaultDraw draw(wiring, seed);
  std::vector<Fault> faults;
  std::int64_t time_ns = from_ns;
  while (static_cast<std::int32_t>(faults.size()) < count) {
    const FaultType& type = *fault_types()[draw.below(fault_types().size())];
    if (type.draw == nullptr || (type.can_be_drawn != nullptr && !type.can_be_drawn(wiring, faults))) continue;
    if (!faults.empty())
      time_ns += draw.below(2) == 0 ? draw.time_between(0, 10 * ms) : draw.time_between(10 * ms, 100 * ms);
    Fault fault;
    fault.kind = static_cast<FaultKind>(type.number);
    fault.time_ns = time_ns;
    draw.begin_fault();
    type.draw(draw, fault);
    faults.push_back(fault);
  }
  return faults;
}

}  // namespace robotskin::world
