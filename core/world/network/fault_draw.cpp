// Faults that fit a wiring: the check of given ones, and the drawing of random ones.
#include <algorithm>

#include "robotskin/wire.h"
#include "world/network/fault.hpp"
#include "world/random.hpp"

namespace robotskin::world {
namespace {

constexpr std::int64_t ms = 1000000;
constexpr std::uint64_t purpose_faults = 31;

// Faults of which one of `cell` and `unit` names the place.
bool of_either(FaultKind kind) {
  return kind == FaultKind::cut || kind == FaultKind::mend || kind == FaultKind::oneway || kind == FaultKind::flap ||
         kind == FaultKind::drift;
}

bool between_units(FaultKind kind) {
  return kind == FaultKind::delay || kind == FaultKind::loss || kind == FaultKind::partition;
}

}  // namespace

void check_fault(const Fault& fault, const Wiring& wiring) {
  const auto refuse = [&fault](const std::string& why) {
    throw FaultError("fault '" + to_string(fault) + "': " + why);
  };
  const auto cells = static_cast<std::int64_t>(wiring.cell_count());
  const auto units = static_cast<std::int64_t>(wiring.units.size());
  const auto cell_exists = [&](std::int64_t cell) {
    if (cell >= cells) refuse("cell " + std::to_string(cell) + ": there are cells 0 to " + std::to_string(cells - 1));
  };
  const auto unit_exists = [&](std::int64_t unit) {
    if (unit >= units) refuse("unit " + std::to_string(unit) + ": there are units 0 to " + std::to_string(units - 1));
  };
  cell_exists(fault.cell);
  unit_exists(fault.unit);
  if (fault.kind == FaultKind::plug || fault.kind == FaultKind::twin) cell_exists(fault.to);
  if (fault.kind == FaultKind::twin && fault.to < 0) refuse("to=-1: there are cells 0 to " + std::to_string(cells - 1));
  if (between_units(fault.kind)) unit_exists(fault.to);
  if (of_either(fault.kind) && (fault.cell < 0) == (fault.unit < 0)) refuse("give either cell or unit");
  if (fault.cell >= 0 && fault.unit >= 0) refuse("give either cell or unit");
  if ((fault.kind == FaultKind::noise || fault.kind == FaultKind::burst) && fault.port != 0 && fault.cell < 0 &&
      fault.unit < 0)
    refuse("whose port? give either cell or unit");
  if (fault.cell >= 0 && fault.port > RS_PORTS) refuse("port " + std::to_string(fault.port) + ": a cell has 1 to 4");
  if (fault.unit >= 0) {
    const auto ports = static_cast<std::int32_t>(wiring.units[static_cast<std::size_t>(fault.unit)].ports.size());
    if (fault.port > ports)
      refuse("port " + std::to_string(fault.port) + ": unit " + std::to_string(fault.unit) + " has 1 to " +
             std::to_string(ports));
  }
  if (fault.by_ns < 0 && fault.kind != FaultKind::skew) refuse("by: must not be negative");
}

std::vector<Fault> draw_faults(const Wiring& wiring, std::int32_t count, std::int64_t from_ns, std::uint64_t seed) {
  RandomStream draw(stream_key(seed, purpose_faults, 0));
  const auto cells = static_cast<std::int32_t>(wiring.cell_count());
  const auto units = static_cast<std::int32_t>(wiring.units.size());
  const auto time_between = [&draw](std::int64_t low_ns, std::int64_t high_ns) {  // whole 10 us
    return (low_ns + static_cast<std::int64_t>(draw.below(static_cast<std::uint64_t>(high_ns - low_ns + 1)))) / 10000 *
           10000;
  };
  const auto draw_cell = [&] { return static_cast<std::int32_t>(draw.below(static_cast<std::uint64_t>(cells))); };
  // A port with something at it, of a cell.
  const auto draw_port = [&](std::int32_t cell) {
    std::vector<std::int32_t> ports;
    for (std::int32_t p = 1; p <= RS_PORTS; ++p)
      if (wiring.neighbours[static_cast<std::size_t>(cell)][static_cast<std::size_t>(p) - 1].cell >= 0)
        ports.push_back(p);
    return ports.empty() ? 1 : ports[draw.below(ports.size())];
  };
  // One with anything at it, a section unit too.
  const auto draw_wired_port = [&](std::int32_t cell) {
    for (const UnitDescription& unit : wiring.units)
      for (const CellEnd& end : unit.ports)
        if (end.cell == cell && draw.below(4) == 0) return static_cast<std::int32_t>(end.port);
    return draw_port(cell);
  };
  const auto draw_unit = [&] { return static_cast<std::int32_t>(draw.below(static_cast<std::uint64_t>(units))); };
  const auto draw_unit_port = [&](std::int32_t unit) {
    return 1 + static_cast<std::int32_t>(draw.below(wiring.units[static_cast<std::size_t>(unit)].ports.size()));
  };

  std::vector<Fault> faults;
  std::int64_t time_ns = from_ns;
  while (static_cast<std::int32_t>(faults.size()) < count) {
    const auto kind = static_cast<FaultKind>(draw.below(fault_names().size()));
    if (kind == FaultKind::mend || (units < 2 && between_units(kind))) continue;
    if (units == 0 && (kind == FaultKind::skew || kind == FaultKind::stop || kind == FaultKind::power)) continue;
    if (kind == FaultKind::twin && cells < 2) continue;
    if (kind == FaultKind::wrap &&
        std::ranges::any_of(faults, [](const Fault& f) { return f.kind == FaultKind::wrap; }))
      continue;
    if (!faults.empty()) time_ns += draw.below(2) == 0 ? time_between(0, 10 * ms) : time_between(10 * ms, 100 * ms);
    Fault fault;
    fault.kind = kind;
    fault.time_ns = time_ns;
    const bool for_a_while = draw.below(2) == 0;
    const auto while_ns = [&](std::int64_t low_ns, std::int64_t high_ns) {
      return for_a_while ? time_between(low_ns, high_ns) : 0;
    };
    switch (kind) {
      case FaultKind::cut:
      case FaultKind::oneway:
      case FaultKind::flap:
        // One in eight at a section unit's port, that is, a cable.
        if (units > 0 && draw.below(8) == 0) {
          fault.unit = draw_unit();
          fault.port = draw_unit_port(fault.unit);
        } else {
          fault.cell = draw_cell();
          fault.port = draw_port(fault.cell);
        }
        if (kind == FaultKind::oneway) fault.way = draw.below(2) == 0 ? FaultWay::out : FaultWay::in;
        if (kind == FaultKind::flap) {
          fault.count = 1 + static_cast<std::int32_t>(draw.below(8));
          fault.by_ns = time_between(ms / 2, 16 * ms);
        } else {
          fault.lasts_ns = while_ns(ms, 60 * ms);
        }
        break;
      case FaultKind::noise:
      case FaultKind::burst:
        if (draw.below(2) == 0) {
          fault.cell = draw_cell();
          fault.port = draw_port(fault.cell);
        }
        fault.lasts_ns = kind == FaultKind::noise ? time_between(ms, 40 * ms) : time_between(ms / 10, 6 * ms);
        fault.amount = kind == FaultKind::noise ? static_cast<double>(1 + draw.below(50)) / 10000
                                                : static_cast<double>(1 + draw.below(20)) / 20;
        break;
      case FaultKind::slow:
        fault.cell = draw_cell();
        fault.by_ns = time_between(ms / 20, ms);
        fault.lasts_ns = time_between(ms, 40 * ms);
        break;
      case FaultKind::zombie:
        fault.cell = draw_cell();
        fault.lasts_ns = while_ns(ms, 60 * ms);
        break;
      case FaultKind::crash:
        fault.cell = draw_cell();
        break;
      case FaultKind::reboot:
        fault.cell = draw_cell();
        fault.lasts_ns = time_between(ms / 10, 10 * ms);
        break;
      case FaultKind::ram:
        fault.cell = draw_cell();
        fault.count = 1 << draw.below(8);
        fault.part = static_cast<FaultPart>(draw.below(4));
        break;
      case FaultKind::stuff:
        fault.cell = draw_cell();
        fault.port = draw_port(fault.cell);
        fault.count = 20 + static_cast<std::int32_t>(draw.below(180));
        break;
      case FaultKind::forge:
      case FaultKind::replay:
        fault.cell = draw_cell();
        fault.port = draw_wired_port(fault.cell);
        fault.count = 1 + static_cast<std::int32_t>(draw.below(30));
        fault.by_ns = time_between(ms / 4, 4 * ms);
        if (kind == FaultKind::forge)
          fault.what = static_cast<FaultFrame>(draw.below(4));
        else
          fault.lasts_ns = time_between(2 * ms, 200 * ms);
        break;
      case FaultKind::twin:
        fault.cell = draw_cell();
        do fault.to = draw_cell();
        while (fault.to == fault.cell);
        fault.lasts_ns = time_between(ms / 10, 10 * ms);
        break;
      case FaultKind::plug:
        fault.cell = draw_cell();
        fault.port = draw_port(fault.cell);
        fault.to = draw_cell();
        fault.to_port = draw_port(fault.to);
        fault.lasts_ns = while_ns(ms, 60 * ms);
        break;
      case FaultKind::late:
        fault.cell = draw_cell();
        fault.count = 1 + static_cast<std::int32_t>(draw.below(static_cast<std::uint64_t>(std::max(cells / 4, 1))));
        break;
      case FaultKind::drift:
        if (units > 0 && draw.below(2) == 0)
          fault.unit = draw_unit();
        else
          fault.cell = draw_cell();
        // Cells' oscillators are bad, section units have crystals.
        fault.amount = (fault.unit < 0 ? 100.0 : 1.0) * (static_cast<double>(draw.below(401)) - 200);
        break;
      case FaultKind::skew:
        fault.unit = draw_unit();
        fault.by_ns = time_between(0, 6 * ms) - 3 * ms;
        break;
      case FaultKind::stop:
        fault.unit = draw_unit();
        fault.lasts_ns = while_ns(ms, 60 * ms);
        break;
      case FaultKind::power:
        fault.unit = draw_unit();
        fault.port = draw_unit_port(fault.unit);
        fault.lasts_ns = while_ns(ms, 60 * ms);
        break;
      case FaultKind::delay:
      case FaultKind::loss:
      case FaultKind::partition:
        fault.unit = draw_unit();
        fault.by_ns = kind == FaultKind::delay ? time_between(ms / 10, 40 * ms) : 0;
        fault.amount = kind == FaultKind::loss ? static_cast<double>(1 + draw.below(20)) / 20 : 0;
        fault.lasts_ns = while_ns(10 * ms, 100 * ms);
        break;
      case FaultKind::wrap:
      case FaultKind::mend:
        break;
    }
    faults.push_back(fault);
  }
  return faults;
}

}  // namespace robotskin::world
