// SPDX-License-Identifier: Apache-2.0
// What faults of the Ethernet between section units have in common: when they end, and that they are in force till
// then.
#pragma once

#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {

inline void draw_ethernet_end(FaultDraw& draw, Fault& fault) {
  fault.lasts_ns = draw.while_ns(10 * FaultDraw::ms, 100 * FaultDraw::ms);
}

inline bool is_on_the_way(const Fault& fault, const FaultyPassage& passage) {
  return passage.from == static_cast<std::size_t>(fault.unit) &&
         (fault.to < 0 || passage.to == static_cast<std::size_t>(fault.to));
}

inline void begin_ethernet_trouble(Network::RunningFault& act, int) {
  act.trouble_ethernet(true);
}

inline void end_ethernet_trouble(Network::RunningFault& act) {
  act.trouble_ethernet(false);
}

}  // namespace robotskin::world::faults
