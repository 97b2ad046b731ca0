// SPDX-License-Identifier: Apache-2.0
#include "campaign/advert_log.hpp"

namespace robotskin::campaign {

void AdvertLog::issued(const rs_tick& tick) {
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

void AdvertLog::arrived(std::size_t at_wire, const rs_tick& tick, std::int64_t now_ns) {
  Port& port = arrived_[at_wire];
  port.last = static_cast<std::uint8_t>((port.last + 1) % adverts_kept);
  port.advert[port.last] = {now_ns,
                            static_cast<std::uint16_t>(tick.sequence),
                            static_cast<std::uint8_t>(tick.hops),
                            static_cast<std::uint8_t>(tick.root),
                            tick.parent != 0,
                            false};
}

void AdvertLog::planted(std::size_t at_wire, const rs_tick& tick, std::int64_t now_ns) {
  if (find(at_wire, static_cast<std::uint16_t>(tick.sequence), static_cast<std::uint8_t>(tick.hops)) != nullptr) return;
  arrived(at_wire, tick, now_ns);
  arrived_[at_wire].advert[arrived_[at_wire].last].planted = true;
}

const IssuedTick* AdvertLog::find(const rs_wave& wave) const {
  const std::vector<IssuedTick>& of_root = issued_[wave.root];
  if (of_root.empty()) return nullptr;
  const IssuedTick& tick = of_root[wave.sequence % ticks_kept];
  const bool same = tick.valid && tick.sequence == wave.sequence && tick.era == wave.era && tick.tag == wave.tag;
  return same ? &tick : nullptr;
}

const ArrivedAdvert* AdvertLog::find(std::size_t at_wire, std::uint16_t sequence, std::uint8_t hops) const {
  const Port& port = arrived_[at_wire];
  for (std::size_t back = 0; back < adverts_kept; ++back) {
    const ArrivedAdvert& advert = port.advert[(port.last + adverts_kept - back) % adverts_kept];
    if (advert.time_ns >= 0 && advert.sequence == sequence && advert.hops == hops) return &advert;
  }
  return nullptr;
}

}  // namespace robotskin::campaign
