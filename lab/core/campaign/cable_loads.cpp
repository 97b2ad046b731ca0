// SPDX-License-Identifier: Apache-2.0
#include "campaign/cable_loads.hpp"

#include <algorithm>

namespace robotskin::campaign {

void CableLoads::weigh(const world::Network& network, const GroundTruth& ground,
                       std::span<const std::uint32_t> late_sums) {
  const std::int64_t now_ns = network.time_ns();
  cells_.fill(0);
  deepest_.fill(0);
  const auto attached = [&](std::size_t cell) {
    return ground.runs(cell) && network.cell(cell).route.parent_port != RS_NO_PARENT;
  };
  for (std::size_t cell = 0; cell < network.cell_count(); ++cell) {
    const rs_route& route = network.cell(cell).route;
    if (!attached(cell)) continue;
    ++cells_[route.wave.root];
    deepest_[route.wave.root] = std::max<std::int32_t>(deepest_[route.wave.root], route.hops);
  }
  for (std::size_t root = 0; root < roots; ++root) {
    const bool sent_more = by_sent_ && sent_[root] > cells_carried_ * bursts_carried;
    overloaded_[root] = cells_[root] + late_sums[root] > cells_carried_ || sent_more;
    if (overloaded_[root] != 0) overloaded_root_ns_[root] = now_ns;
    const std::uint32_t sent = sent_[root] + late_sums[root];  // sums that go one by one take the place of samples
    if (sent > cells_carried_) excess_ += std::min(sent - cells_carried_, sent_[root]);
    sent_[root] = 0;
  }
  // A cell that takes another parent may bring along what had to wait.
  for (std::size_t cell = 0; cell < network.cell_count(); ++cell)
    if (attached(cell)) {
      std::int64_t& of_root_ns = overloaded_root_ns_[network.cell(cell).route.wave.root];
      of_root_ns = std::max(of_root_ns, overloaded_cell_ns_[cell]);
    }
  for (std::size_t root = 0; root < roots; ++root) {
    std::int64_t& of_unit_ns = overloaded_unit_ns_[unit_of(root)];
    of_unit_ns = std::max(of_unit_ns, overloaded_root_ns_[root]);
  }
  for (std::size_t cell = 0; cell < network.cell_count(); ++cell)
    if (attached(cell)) overloaded_cell_ns_[cell] = overloaded_root_ns_[network.cell(cell).route.wave.root];
}

}  // namespace robotskin::campaign
