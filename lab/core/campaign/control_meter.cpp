// SPDX-License-Identifier: Apache-2.0
#include "campaign/control_meter.hpp"

#include <algorithm>

#include "robotskin/timing.h"

namespace robotskin::campaign {

void ControlMeter::frame_sent(const GroundTruth& ground, std::size_t index, const std::uint8_t* frame,
                              std::int64_t now_ns) {
  const unsigned type = frame[0] >> 4;
  if (type != RS_TYPE_tick && type != RS_TYPE_status && type != RS_TYPE_grant) return;
  Wire& wire = wires_[index];
  ++wire.control;
  if (type != RS_TYPE_tick) return;
  ++wire.beacons;
  wire.beacon_ns[wire.next] = now_ns;
  wire.next = static_cast<std::uint8_t>((wire.next + 1) % wire.beacon_ns.size());
  const std::int64_t first_ns = wire.beacon_ns[wire.next];
  if (first_ns == 0 || now_ns - first_ns >= beacon_window_ns_) return;
  const bool cell = ground.is_cell(index);
  if (cell && now_ns < ground.shaken_until_ns(GroundTruth::cell_of(index)) + held_ns_) return;
  if (cell ? ground.lawless(now_ns, GroundTruth::cell_of(index)) : ground.lawless(now_ns)) return;
  breaks_.add(Invariant::beacon_rate, now_ns, {cell ? GroundTruth::cell_of(index) : index},
              {{"port", static_cast<std::int64_t>(index % RS_PORTS) + 1},
               {"of a cell", cell},
               {"us for five beacons", (now_ns - first_ns) / us}});
}

void ControlMeter::poll(const world::Network& network, const GroundTruth& ground, const Overruns& overruns) {
  const std::int64_t now_ns = network.time_ns();
  // Kept by cell, since one that asked for lost frames again may hang in another tree by the end of the window.
  for (std::size_t cell = 0; cell < overtaxed_ns_.size(); ++cell) {
    if (!ground.runs(cell)) continue;
    overtaxed_ns_[cell] = std::max(overtaxed_ns_[cell], overruns.overtaxed_ns(network.cell(cell).route.wave.root));
  }
  if (now_ns < window_start_ns_ + window_ns) return;
  const bool quiet = ground.repaired_ns() < window_start_ns_;
  const auto capacity = static_cast<double>(now_ns - window_start_ns_) / (RS_FRAME_US * us);
  for (std::size_t index = 0; index < wires_.size(); ++index) {
    Wire& wire = wires_[index];
    const double share = wire.control / capacity;
    const double beacons = wire.beacons / capacity;
    wire.control = wire.beacons = 0;
    if (!quiet || !ground.joined(index)) continue;
    if (ground.is_cell(index) && overtaxed_ns_[GroundTruth::cell_of(index)] >= window_start_ns_) continue;
    largest_share_ = std::max(largest_share_, share);
    if (share <= share_max) continue;
    breaks_.add(Invariant::control_share, now_ns, {ground.is_cell(index) ? GroundTruth::cell_of(index) : index},
                {{"1/1000 of the wire", static_cast<std::int64_t>(1e3 * share)},
                 {"of it beacons", static_cast<std::int64_t>(1e3 * beacons)}});
  }
  window_start_ns_ = now_ns;
}

}  // namespace robotskin::campaign
