// SPDX-License-Identifier: Apache-2.0
#include "campaign/overruns.hpp"

#include "campaign/epoch_times.hpp"

namespace robotskin::campaign {

void Overruns::weigh(std::int64_t now_ns, const CableLoads& loads, std::span<const std::uint32_t> late_sums) {
  for (std::size_t root = 0; root < overloaded_ns_.size(); ++root) {
    const bool single_sums = limbs_ > 0 && late_sums[root] > 0 && !sums_in_time(loads.deepest()[root], limbs_, times_);
    if (loads.overloaded()[root] != 0 || single_sums) overloaded_ns_[root] = now_ns;
  }
}

bool Overruns::lost(const world::Network& network, const GroundTruth& ground, std::size_t cell) {
  const std::int64_t now_ns = network.time_ns();
  const std::uint8_t root = network.cell(cell).route.wave.root;
  const bool overloaded = now_ns - overloaded_ns_[root] < CableLoads::drained_ns;
  if (overloaded) overtaxed_ns_[root] = now_ns;
  return overloaded || ground.moving(now_ns) || now_ns < ground.repaired_ns() + times_.catch_up_ns;
}

}  // namespace robotskin::campaign
