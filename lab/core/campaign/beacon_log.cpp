// SPDX-License-Identifier: Apache-2.0
#include "campaign/beacon_log.hpp"

namespace robotskin::campaign {

void BeaconLog::issued(const rs_tick& tick) {
  std::vector<IssuedTick>& of_root = issued_[tick.root & 0xFFU];
  of_root.resize(ticks_kept);
  of_root[tick.sequence % ticks_kept] = {tick.tag,
                                         static_cast<std::uint16_t>(tick.sequence),
                                         static_cast<std::uint16_t>(tick.era),
                                         static_cast<std::uint8_t>(tick.root),
                                         static_cast<std::uint8_t>(tick.rate_divisor),
                                         static_cast<std::uint8_t>(tick.depth_cap),
                                         static_cast<std::uint8_t>(tick.gain_threshold),
                                         true};
  const std::uint32_t time = tick.era << 16 | tick.sequence;
  if (!any_ || static_cast<std::int32_t>((time - newest_time_) << 6) > 0) newest_time_ = time;
  any_ = true;
}

void BeaconLog::keep(std::size_t at_wire, const rs_tick& tick, std::int64_t now_ns, bool planted) {
  Port& port = arrived_[at_wire];
  port.last = static_cast<std::uint8_t>((port.last + 1) % beacons_kept);
  port.beacon[port.last] = {now_ns,
                            static_cast<std::uint16_t>(tick.sequence),
                            static_cast<std::uint8_t>(tick.hops),
                            static_cast<std::uint8_t>(tick.root),
                            tick.parent != 0,
                            planted};
}

void BeaconLog::arrived(std::size_t at_wire, const rs_tick& tick, std::int64_t now_ns) {
  keep(at_wire, tick, now_ns, false);
  arrived_[at_wire].own_child = tick.parent != 0;
}

void BeaconLog::planted(std::size_t at_wire, const rs_tick& tick, std::int64_t now_ns) {
  if (find(at_wire, static_cast<std::uint16_t>(tick.sequence), static_cast<std::uint8_t>(tick.hops)) != nullptr) return;
  keep(at_wire, tick, now_ns, true);
}

const IssuedTick* BeaconLog::find(const rs_wave& wave) const {
  const std::vector<IssuedTick>& of_root = issued_[wave.root];
  if (of_root.empty()) return nullptr;
  const IssuedTick& tick = of_root[wave.sequence % ticks_kept];
  const bool same = tick.valid && tick.sequence == wave.sequence && tick.era == wave.era && tick.tag == wave.tag;
  return same ? &tick : nullptr;
}

const ArrivedBeacon* BeaconLog::find(std::size_t at_wire, std::uint16_t sequence, std::uint8_t hops) const {
  const Port& port = arrived_[at_wire];
  for (std::size_t back = 0; back < beacons_kept; ++back) {
    const ArrivedBeacon& beacon = port.beacon[(port.last + beacons_kept - back) % beacons_kept];
    if (beacon.time_ns >= 0 && beacon.sequence == sequence && beacon.hops == hops) return &beacon;
  }
  return nullptr;
}

}  // namespace robotskin::campaign
