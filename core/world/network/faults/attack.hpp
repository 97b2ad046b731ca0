// SPDX-License-Identifier: Apache-2.0
// What forged and replayed frames have in common: a port with something at it, and times.
#pragma once

#include "world/network/fault_type.hpp"

namespace robotskin::world::faults {

inline void draw_attack(FaultDraw& draw, Fault& fault) {
  fault.cell = draw.cell();
  fault.port = draw.wired_port(fault.cell);
  fault.count = 1 + static_cast<std::int32_t>(draw.below(30));
  fault.by_ns = draw.time_between(FaultDraw::ms / 4, 4 * FaultDraw::ms);
}

}  // namespace robotskin::world::faults
