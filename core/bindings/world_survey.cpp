// SPDX-License-Identifier: Apache-2.0
// Binds what is so in a simulated network at one moment: a row for every cell.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstdint>
#include <vector>

#include "bindings/arrays.hpp"
#include "bindings/world.hpp"
#include "world/network/network.hpp"

namespace nb = nanobind;

namespace robotskin::bindings {
namespace {

using world::Network;

template <typename Value, typename Read>
auto column(const Network& network, Read read) {
  std::vector<Value> values(network.cell_count());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<Value>(read(i));
  return copy_of<Value>(std::span<const Value>(values));
}

nb::dict survey(const Network& network) {
  const auto route = [&](std::size_t i) -> const rs_route& { return network.cell(i).route; };
  std::vector<std::uint32_t> damaged(RS_PORTS * network.cell_count());
  for (std::size_t i = 0; i < network.cell_count(); ++i)
    for (std::size_t p = 0; p < RS_PORTS; ++p) damaged[RS_PORTS * i + p] = route(i).neighbour[p].lost;
  nb::dict result;
  result["alive"] = column<std::uint8_t>(network, [&](std::size_t i) { return network.alive(i); });
  result["parent_port"] = column<std::uint8_t>(network, [&](std::size_t i) { return route(i).parent_port; });
  result["hops"] = column<std::uint8_t>(network, [&](std::size_t i) { return route(i).hops; });
  result["parent_changes"] =
      column<std::uint32_t>(network, [&](std::size_t i) { return network.cell(i).counts.parent_changes; });
  result["damaged"] = copy_of<std::uint32_t>(std::span<const std::uint32_t>(damaged),
                                             {network.cell_count(), static_cast<std::size_t>(RS_PORTS)});
  return result;
}

}  // namespace

void bind_world_survey(nb::class_<Network>& network) {
  network.def("survey", &survey,
              "A row for every cell, as it is now: `alive` (1: has power and runs), `parent_port` (0: none), `hops` "
              "(255: no path), "
              "`parent_changes` since its boot, and `damaged` (N, 4), frames with a wrong checksum at each port.");
}

}  // namespace robotskin::bindings
