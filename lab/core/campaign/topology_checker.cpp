// SPDX-License-Identifier: Apache-2.0
#include "campaign/topology_checker.hpp"

#include <array>
#include <utility>

#include "campaign/datagram_frames.hpp"

namespace robotskin::campaign {

void TopologyChecker::datagram(const world::Network& network, std::span<const std::uint8_t> datagram) {
  for_each_frame(datagram, [&](const std::uint8_t* frame_at) {
    if (rs_frame_type_of(frame_at) != RS_TYPE_topology) return;
    rs_topology topology;
    rs_topology_unpack(&topology, frame_at);
    // The world gives cell i the serial number i + 1.
    if (topology.source == RS_ID_SECTION_UNIT || topology.uid == 0 || topology.uid > told_.size()) return;
    Told& told = told_[topology.uid - 1];
    told.time_ns = network.time_ns();
    told.topology = topology;
  });
}

void TopologyChecker::crowded_out(std::int64_t now_ns, const std::uint8_t* frame) {
  if (rs_frame_type_of(frame) != RS_TYPE_topology) return;
  rs_topology topology;
  rs_topology_unpack(&topology, frame);
  if (topology.uid != 0 && topology.uid <= told_.size()) told_[topology.uid - 1].crowded_out_ns = now_ns;
}

void TopologyChecker::cell_stepped(const world::Network& network, std::size_t cell, const rs_input& input,
                                   bool within_load) {
  const std::uint32_t dropped = network.cell(cell).counts.repeats_dropped;
  if (std::exchange(dropped_[cell], dropped) == dropped || within_load) return;
  if (input.kind == RS_INPUT_FRAME)
    crowded_out(network.time_ns(), input.frame);
  else
    told_[cell].crowded_out_ns = network.time_ns();
}

void TopologyChecker::finish(const world::Network& network, const GroundTruth& ground, const RecoveryChecker& recovery,
                             const Overruns& overruns) {
  const std::int64_t since_ns = network.time_ns() - known_ns;
  if (ground.repaired_ns() > since_ns || !ground.calm(network.time_ns()) || recovery.whole_since_ns() > since_ns)
    return;
  for (std::size_t cell = 0; cell < told_.size(); ++cell)
    if (recovery.has_path(cell) && ground.booted_ns(cell) < since_ns && told_[cell].crowded_out_ns < since_ns &&
        overruns.overtaxed_ns(network.cell(cell).route.wave.root) < since_ns)
      judge(network, ground, cell);
  if (losses_.too_many())
    breaks_.add(Invariant::host_topology, network.time_ns(), {},
                {{"untold on lossy lines", losses_.lost()}, {"at most", losses_.at_most()}});
}

void TopologyChecker::judge(const world::Network& network, const GroundTruth& ground, std::size_t cell) {
  const std::int64_t now_ns = network.time_ns();
  const Told& told = told_[cell];
  const rs_topology& said = told.topology;
  ++judged_;
  losses_.due(network.cell(cell).route.hops);
  if (!losses_.whole() && told.time_ns < now_ns - known_ns) return losses_.add(1);
  if (told.time_ns < now_ns - known_ns || said.source != network.cell(cell).id) {
    breaks_.add(Invariant::host_topology, now_ns, {cell},
                {{"id", network.cell(cell).id},
                 {"told as", said.source},
                 {"us ago", told.time_ns < 0 ? -1 : (now_ns - told.time_ns) / us}});
    return;
  }
  const std::array<std::uint32_t, RS_PORTS> ids{said.neighbour_1, said.neighbour_2, said.neighbour_3, said.neighbour_4};
  const std::array<std::uint32_t, RS_PORTS> ports{said.neighbour_port_1, said.neighbour_port_2, said.neighbour_port_3,
                                                  said.neighbour_port_4};
  for (unsigned port = 1; port <= RS_PORTS; ++port) {
    const std::size_t wire = ground.wire_of_cell(cell, port);
    const std::int32_t far = ground.far(wire);
    std::uint32_t id = RS_ID_NONE, far_port = 0;
    if (ground.joined(wire)) {
      // A link that was let in only lately may have been told or not.
      if (!ground.ready(wire, now_ns - known_ns)) continue;
      const auto other = static_cast<std::size_t>(far);
      if (ground.is_cell(other)) {
        if (ground.is_zombie(GroundTruth::cell_of(other))) continue;
        id = network.cell(GroundTruth::cell_of(other)).id;
        far_port = static_cast<std::uint32_t>(other % RS_PORTS);
      } else {
        id = RS_ID_SECTION_UNIT;
        far_port = ports[port - 1];
      }
    } else if (far != GroundTruth::no_wire) {
      continue;  // carries one way, or no cell runs there
    }
    if (ids[port - 1] == id && (id == RS_ID_NONE || ports[port - 1] == far_port)) continue;
    if (!losses_.whole()) return losses_.add(1);
    breaks_.add(Invariant::host_topology, now_ns, {cell},
                {{"port", port},
                 {"neighbour", id},
                 {"at its port", far_port + 1},
                 {"told", ids[port - 1]},
                 {"at port", ports[port - 1] + 1}});
  }
}

}  // namespace robotskin::campaign
