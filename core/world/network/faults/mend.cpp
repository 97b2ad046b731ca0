// SPDX-License-Identifier: Apache-2.0
// A wire that is whole again.
#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

void begin(Network::RunningFault& act, int) {
  act.cut(false, false);
}

}  // namespace

constinit const FaultType mend{
    .number = 1,
    .name = "mend",
    .keys = "cell unit port!",
    .text = "and everything again",
    .either = true,
    .begin = begin,
    .tell = tell_change,
};

}  // namespace robotskin::world::faults
