// SPDX-License-Identifier: Apache-2.0
// What noise and bursts have in common: a place, and how often links go down meanwhile.
#pragma once

#include <cmath>

#include "world/network/fault_type.hpp"

namespace robotskin::world::faults {

inline void draw_line_place(FaultDraw& draw, Fault& fault) {
  if (draw.below(2) != 0) return;
  fault.cell = draw.cell();
  fault.port = draw.port(fault.cell);
}

// `lost` is the share of frames that do not arrive whole. A link goes down when three in a row fail: never, if they
// hardly ever do.
inline void tell_line_trouble(const Fault& fault, bool begins, double lost, FaultWitness& witness) {
  constexpr std::int64_t down_and_up_ns = 6 * FaultDraw::ms;
  const double threes = std::pow(lost, 3) * 1e-6 * static_cast<double>(fault.lasts_ns);
  const std::int64_t downs = threes > 1e-9 ? 1 + fault.lasts_ns / down_and_up_ns : 0;
  if (begins) witness.links_fall(fault, fault.lasts_ns, static_cast<std::int32_t>(downs));
  witness.disturbed(begins ? fault.lasts_ns : 0);
}

}  // namespace robotskin::world::faults
