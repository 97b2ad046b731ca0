// SPDX-License-Identifier: Apache-2.0
// The list of kinds, and whether a fault fits a wiring.
#include <algorithm>
#include <stdexcept>

#include "robotskin/wire.h"
#include "world/network/fault_type.hpp"

namespace robotskin::world {

std::span<const FaultType* const> fault_types() {
  static const std::vector<const FaultType*> types = [] {
    std::vector<const FaultType*> found;
#define ROBOTSKIN_FAULT(name) found.push_back(&faults::name);
#include "world/network/fault_list.inc"
#undef ROBOTSKIN_FAULT
    std::ranges::sort(found, {}, [](const FaultType* type) { return type->number; });
    for (std::size_t number = 0; number < found.size(); ++number)
      if (found[number]->number != number)
        throw std::logic_error("fault " + std::string(found[number]->name) + " has number " +
                               std::to_string(found[number]->number) + ", and number " + std::to_string(number) +
                               " is the next");
    return found;
  }();
  return types;
}

const FaultType& type_of(const Fault& fault) {
  return *fault_types()[static_cast<std::size_t>(fault.kind)];
}

std::int64_t duration_ns(const Fault& fault) {
  const FaultCourse course = type_of(fault).course;
  return course == FaultCourse::alternating || course == FaultCourse::repeated ? fault.count * fault.by_ns
                                                                               : fault.lasts_ns;
}

void check_fault(const Fault& fault, const Wiring& wiring) {
  const auto refuse = [&fault](const std::string& why) {
    throw FaultError("fault '" + to_string(fault) + "': " + why);
  };
  const FaultType& type = type_of(fault);
  const auto cells = static_cast<std::int64_t>(wiring.cell_count());
  const auto units = static_cast<std::int64_t>(wiring.units.size());
  const auto cell_exists = [&](std::int64_t cell) {
    if (cell >= cells) refuse("cell " + std::to_string(cell) + ": there are cells 0 to " + std::to_string(cells - 1));
  };
  const auto unit_exists = [&](std::int64_t unit) {
    // In words as in the text of a fault, units count from 1.
    if (unit >= units) refuse("unit " + std::to_string(unit + 1) + ": there are units 1 to " + std::to_string(units));
  };
  cell_exists(fault.cell);
  unit_exists(fault.unit);
  if (type.to == FaultTo::cell || type.to == FaultTo::cell_or_none) cell_exists(fault.to);
  if (type.to == FaultTo::cell && fault.to < 0) refuse("to=-1: there are cells 0 to " + std::to_string(cells - 1));
  if (type.to == FaultTo::unit) unit_exists(fault.to);
  if (type.either && (fault.cell < 0) == (fault.unit < 0)) refuse("give either cell or unit");
  if (fault.cell >= 0 && fault.unit >= 0) refuse("give either cell or unit");
  if (fault.port != 0 && fault.cell < 0 && fault.unit < 0) refuse("whose port? give either cell or unit");
  if (fault.cell >= 0 && fault.port > RS_PORTS) refuse("port " + std::to_string(fault.port) + ": a cell has 1 to 4");
  if (fault.unit >= 0) {
    const auto ports = static_cast<std::int32_t>(wiring.units[static_cast<std::size_t>(fault.unit)].ports.size());
    if (fault.port > ports)
      refuse("port " + std::to_string(fault.port) + ": unit " + std::to_string(fault.unit + 1) + " has 1 to " +
             std::to_string(ports));
  }
  if (fault.by_ns < 0 && !type.may_go_back) refuse("by: must not be negative");
}

}  // namespace robotskin::world
