// SPDX-License-Identifier: Apache-2.0
#include "campaign/overruns.hpp"

namespace robotskin::campaign {

void Overruns::weigh(std::int64_t now_ns, std::span<const std::uint32_t> load) {
  for (std::size_t root = 0; root < load.size(); ++root)
    if (load[root] > cells_carried_) overloaded_ns_[root] = now_ns;
}

bool Overruns::lost(const world::Network& network, const GroundTruth& ground, std::size_t cell) {
  const std::int64_t now_ns = network.time_ns();
  const std::uint8_t root = network.cell(cell).route.wave.root;
  const bool overloaded = now_ns - overloaded_ns_[root] < drained_ns;
  if (overloaded) overtaxed_ns_[root] = now_ns;
  return overloaded || now_ns < ground.repaired_ns() + times_.catch_up_ns;
}

}  // namespace robotskin::campaign
