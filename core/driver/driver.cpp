// SPDX-License-Identifier: Apache-2.0
#include "driver/driver.hpp"

#include <algorithm>

namespace robotskin::driver {
namespace {

constexpr std::size_t departures_max = 8192;

}  // namespace

Driver::Driver(const Options& options)
    : keys_(options.keys),
      index_(options.keys, options.spare_cells, options.spare_groups),
      samples_(index_.capacity()),
      topology_(index_.capacity()),
      units_(units_max),
      joints_(limbs_max),
      references_(index_.capacity(), 0),
      heard_(index_.capacity(), 0),
      arrival_port_(index_.capacity(), 0),
      links_(units_max),
      unit_names_(units_max),
      random_(options.session_seed),
      calendar_ns_(options.calendar_ns) {
  if (options.key) hash_.emplace(*options.key);
  departures_ns_.reserve(departures_max);
  for (std::size_t i = 0; i < options.keys.size(); ++i) samples_.change(i).key = options.keys[i];
  own_sessions_.fill(0);
  pending_units_.reserve(units_max);
  draw_session();
}

// Has the rows that the records name fetched while the tag is computed, which needs no memory.
void Driver::prefetch(const rs_datagram_header& header, std::span<const std::uint8_t> datagram) {
  const CellIndex::Group* group = index_.find(header.group);
  if (group == nullptr) return;
  const std::uint8_t* record = datagram.data() + RS_DATAGRAM_HEADER_BYTES;
  for (unsigned i = 0; i < header.count; ++i, record += RS_DATAGRAM_RECORD_BYTES) {
    rs_clock frame;
    rs_clock_unpack(&frame, record);
    if (!CellIndex::valid(frame.source)) continue;
    const std::int32_t row = group->row[frame.source];
    if (row != CellIndex::no_row) samples_.prefetch(static_cast<std::size_t>(row));
  }
}

Verdict Driver::handle(std::span<const std::uint8_t> datagram, std::int64_t now_ns) {
  return take(datagram, now_ns, !hash_.has_value());
}

Verdict Driver::replay(std::span<const std::uint8_t> datagram, std::int64_t now_ns) {
  return take(datagram, now_ns, true);
}

Verdict Driver::take(std::span<const std::uint8_t> datagram, std::int64_t now_ns, bool trusted) {
  const auto verdict = [&](Verdict which) {
    statistics_.of(which).add();
    return which;
  };
  statistics_.bytes.add(datagram.size());
  if (datagram.size() > RS_DATAGRAM_BYTES_MAX) return verdict(Verdict::truncated);
  rs_datagram_header header;
  switch (rs_datagram_header_unpack(&header, datagram.data(), static_cast<std::uint32_t>(datagram.size()))) {
    case RS_DATAGRAM_OK:
      break;
    case RS_DATAGRAM_TOO_SHORT:
    case RS_DATAGRAM_LENGTH_WRONG:
      return verdict(Verdict::truncated);
    case RS_DATAGRAM_FOREIGN:
    case RS_DATAGRAM_VERSION_ALIEN:
      return verdict(Verdict::foreign);
    case RS_DATAGRAM_KIND_UNKNOWN:
      return verdict(Verdict::malformed);
  }
  const bool upward = header.kind == RS_DATAGRAM_KIND_frames || header.kind == RS_DATAGRAM_KIND_heartbeat;
  if (!upward || header.session == 0 || header.unit == RS_UNIT_ALL || (header.flags & ~RS_DATAGRAM_KEYED) != 0) {
    return verdict(Verdict::malformed);
  }
  prefetch(header, datagram);
  if (!trusted) {
    if ((header.flags & RS_DATAGRAM_KEYED) == 0) return verdict(Verdict::unauthenticated);
    const std::size_t signed_bytes = datagram.size() - RS_DATAGRAM_TAG_BYTES;
    if (!hash_->matches(datagram.first(signed_bytes), datagram.data() + signed_bytes)) {
      return verdict(Verdict::unauthenticated);
    }
  }
  CellIndex::Group* group = index_.group(header.group);
  if (group == nullptr) return verdict(Verdict::foreign);
  std::size_t unit_row = 0;
  const Verdict fresh = check_session(header, now_ns, trusted, &unit_row);
  if (fresh != Verdict::accepted) return verdict(fresh);
  looking_on_ = witness_.load(std::memory_order_acquire);
  if (looking_on_ != nullptr) looking_on_->accepted(datagram, now_ns);

  Link& link = links_[unit_row];
  UnitRow& unit = units_.change(unit_row);
  unit.heard_ns = now_ns;
  unit.clock_offset_ns = link.clock.offset_ns();
  unit.session = header.session;
  ++unit.datagrams;
  const std::uint64_t missing = link.window.missing();
  statistics_.datagrams_lost.add(missing - link.missing_counted);
  unit.datagrams_lost += missing - link.missing_counted;
  link.missing_counted = missing;
  if (static_cast<std::int32_t>(header.dropped - link.dropped) > 0) {
    statistics_.frames_dropped_by_units.add(header.dropped - link.dropped);
    link.dropped = header.dropped;
    unit.frames_dropped = header.dropped;
  }
  statistics_.frames.add(header.count);
  const std::uint8_t* record = datagram.data() + RS_DATAGRAM_HEADER_BYTES;
  for (unsigned i = 0; i < header.count; ++i, record += RS_DATAGRAM_RECORD_BYTES) {
    take_record(header, *group, unit_row, record);
  }
  if (departures_ns_.size() < departures_max) {
    departures_ns_.push_back(std::clamp(link.clock.host_ns(header.time_ns), now_ns - oldest_ns, now_ns));
  }
  last_heard_ = {header.group, header.unit, false};
  return verdict(Verdict::accepted);
}

void Driver::publish(std::int64_t now_ns) {
  samples_.publish(now_ns);
  topology_.publish(now_ns);
  units_.publish(now_ns);
  torques_.rows().publish(now_ns);
  statistics_.publications.add();
  for (const std::int64_t departure_ns : departures_ns_) statistics_.latency.take(now_ns - departure_ns);
  departures_ns_.clear();
  Witness* witness = witness_.load(std::memory_order_acquire);
  if (witness != nullptr) witness->published(*this, samples_.publications(), now_ns);
}

}  // namespace robotskin::driver
