// SPDX-License-Identifier: Apache-2.0
// What the records of an accepted datagram say: samples, neighbours, torques, replies, and the state of ports.
#include <algorithm>
#include <cstdlib>

#include "driver/driver.hpp"

namespace robotskin::driver {
namespace {

// Frames of one cell this close in time are ordered by their sequence number, others by their arrival: the number
// wraps at 256, and a restarted cell begins anywhere.
constexpr std::int64_t sequence_ordered_ns = 100'000'000;

}  // namespace

void Driver::take_record(const rs_datagram_header& header, CellIndex::Group& group, std::size_t unit_row,
                         const std::uint8_t* record) {
  const Link& link = links_[unit_row];
  UnitRow& unit = units_.change(unit_row);
  const std::uint64_t unit_ns = header.time_ns - rs_record_age_us(record) * std::uint64_t{1000};
  const std::int64_t arrival_ns = std::clamp(link.clock.host_ns(unit_ns), unit.heard_ns - oldest_ns, unit.heard_ns);
  switch (rs_frame_type_of(record)) {
    case RS_TYPE_clock:
    case RS_TYPE_event:
      return take_sample(group, unit_row, record, unit_ns, arrival_ns);
    case RS_TYPE_further:
      return take_further(group, record, unit_ns, arrival_ns);
    case RS_TYPE_topology:
      return take_topology(group, unit, record, arrival_ns);
    case RS_TYPE_reply:
      return take_reply(group, unit, record, arrival_ns);
    case RS_TYPE_status: {
      rs_status frame;
      rs_status_unpack(&frame, record);
      UnitPortRow& port = unit.ports[rs_record_port(record)];
      if (rs_record_port(record) == 0) return statistics_.frames_invalid.add();
      statistics_.status_frames.add();
      port.heard_ns = std::max(port.heard_ns, arrival_ns);
      port.size = static_cast<std::uint16_t>(frame.size);
      port.height = static_cast<std::uint8_t>(frame.height);
      return;
    }
    case RS_TYPE_tick:
      return take_rate_divisor(unit_row, record);
    case RS_TYPE_join:
      return statistics_.join_frames.add();
    case RS_TYPE_torque: {
      rs_torque frame;
      rs_torque_unpack(&frame, record);
      statistics_.torque_frames.add();
      // The frame tells its epoch's low bits; a unit may begin an epoch a little early.
      const std::int64_t next = static_cast<std::int64_t>(unit_ns) / epoch_ns + 1;
      const std::int64_t epoch = next - ((next - static_cast<std::int64_t>(frame.epoch)) & RS_EPOCH_MASK);
      const std::int64_t began_ns = link.clock.host_ns(static_cast<std::uint64_t>(epoch * epoch_ns));
      return torques_.take(header.group, header.unit, frame, epoch, began_ns, arrival_ns, statistics_);
    }
    default:
      return statistics_.frames_invalid.add();
  }
}

// Whether a sample is newer than all before it. One that is not has been overtaken, or has come before: after a failure
// cells send again what may have been lost, and say so (`retransmitted`), no more than 16 ms after it was sampled.
bool Driver::is_new(std::size_t row, const rs_clock& frame, std::int64_t arrival_ns) {
  const Sample& before = samples_.row(row);
  std::uint32_t& heard = heard_[row];
  if (!before.seen) {
    heard = 1;
    return true;
  }
  const auto ahead = static_cast<std::int8_t>(static_cast<std::uint8_t>(frame.sequence) - before.sequence);
  const std::int64_t later_ns = arrival_ns - before.arrival_ns;
  const bool close = std::abs(later_ns) < sequence_ordered_ns;
  const bool known = ahead <= 0 && ahead > -32 && (heard >> -ahead & 1U) != 0;
  if (known && (close || frame.retransmitted != 0)) {
    statistics_.frames_duplicated.add();
    return false;
  }
  if (close ? ahead <= 0 : later_ns <= 0) {
    if (close && ahead > -32) heard |= 1U << -ahead;
    statistics_.frames_late.add();
    return false;
  }
  heard = close && ahead < 32 ? heard << ahead | 1U : 1U;
  statistics_.frames_missing.add(static_cast<std::uint8_t>(frame.sequence - before.sequence - 1U));
  return true;
}

void Driver::take_sample(CellIndex::Group& group, std::size_t unit_row, const std::uint8_t* record,
                         std::uint64_t unit_ns, std::int64_t arrival_ns) {
  rs_clock frame;  // an event frame has the same fields
  rs_clock_unpack(&frame, record);
  if (!CellIndex::valid(frame.source)) return statistics_.frames_invalid.add();
  const std::int32_t row = index_.row(group, frame.source);
  if (row == CellIndex::no_row) return statistics_.frames_unknown_cell.add();
  const Sample& before = samples_.row(static_cast<std::size_t>(row));
  if (!is_new(static_cast<std::size_t>(row), frame, arrival_ns)) return;
  const bool event = frame.type == RS_TYPE_event;
  if (event) {
    statistics_.event_frames.add();
    if (frame.refresh) {
      statistics_.refresh_frames.add();
    } else if (before.seen) {
      count_events(before, frame);
    }
  } else {
    statistics_.clock_frames.add();
  }
  Sample& sample = samples_.change(static_cast<std::size_t>(row));
  const auto acceleration = sample.acceleration;
  take_channels(sample, frame);
  sample.key = CellKey{group.number} << 16 | frame.source;
  sample.stamp_ns = arrival_ns - sample_age_ns(frame, unit_ns);
  sample.arrival_ns = arrival_ns;
  if (!sample.seen || acceleration != sample.acceleration) sample.moved_ns = sample.stamp_ns;
  sample.gone_ns = 0;
  (event ? sample.event_frames : sample.clock_frames) += 1;
  sample.sequence = static_cast<std::uint8_t>(frame.sequence);
  sample.seen = true;
  sample.event = event;
  sample.fault = frame.fault != 0;
  sample.refresh = frame.refresh != 0;
  const std::uint32_t port = rs_record_port(record);
  sample.rate_divisor = units_.row(unit_row).ports[port].rate_divisor & 0xF;
  arrival_port_[static_cast<std::size_t>(row)] = static_cast<std::uint16_t>(unit_row << 4 | port);
  if (looking_on_ != nullptr) looking_on_->sampled(sample);
}

template <class Row>
static void stamp_further(Row& sample, std::int64_t stamp_ns) {
  if constexpr (requires { sample.further_ns; }) sample.further_ns = stamp_ns;
}

// The channels behind the nine, of a cell that has sent these. One that has been overtaken says nothing.
void Driver::take_further(CellIndex::Group& group, const std::uint8_t* record, std::uint64_t unit_ns,
                          std::int64_t arrival_ns) {
  rs_further frame;
  rs_further_unpack(&frame, record);
  if (!has_further_channels || !CellIndex::valid(frame.source)) return statistics_.frames_invalid.add();
  const std::int32_t row = index_.row(group, frame.source);
  if (row == CellIndex::no_row) return statistics_.frames_unknown_cell.add();
  statistics_.further_frames.add();
  if (!samples_.row(static_cast<std::size_t>(row)).seen) return;
  const std::int64_t stamp_ns = arrival_ns - sample_age_ns(frame, unit_ns);
  if (stamp_ns < further_ns(samples_.row(static_cast<std::size_t>(row)))) return statistics_.frames_late.add();
  Sample& sample = samples_.change(static_cast<std::size_t>(row));
  take_channels(sample, frame);
  stamp_further(sample, stamp_ns);
}

void Driver::count_events(const Sample& before, const rs_clock& frame) {
  Sample now = before;
  take_channels(now, frame);
  const auto changed = [](const auto& a, const auto& b) {
    std::uint64_t count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) count += a[i] != b[i];
    return count;
  };
#define ROBOTSKIN_CHANGED(name, is_signed, first, channels, column, blank, unit) \
  statistics_.events_##name.add(changed(before.name, now.name));
  RS_SENSORS(ROBOTSKIN_CHANGED)
#undef ROBOTSKIN_CHANGED
}

void Driver::take_topology(CellIndex::Group& group, UnitRow& unit, const std::uint8_t* record,
                           std::int64_t arrival_ns) {
  rs_topology frame;
  rs_topology_unpack(&frame, record);
  if (frame.parent_port > RS_PORTS) return statistics_.frames_invalid.add();
  if (frame.source == RS_ID_SECTION_UNIT) {
    UnitPortRow& port = unit.ports[rs_record_port(record)];
    if (rs_record_port(record) == 0) return statistics_.frames_invalid.add();
    statistics_.topology_frames.add();
    if (arrival_ns < port.heard_ns) return;
    const ReportedNeighbour before{port.cell, port.cell_port, 0};
    const ReportedNeighbour now = topology_row(frame, arrival_ns).neighbours[0];
    port.heard_ns = arrival_ns;
    port.cell = now.id;
    port.cell_port = now.port;
    if (before.id != now.id) {
      reference(group, before, -1, arrival_ns);
      reference(group, now, +1, arrival_ns);
    }
    return;
  }
  if (!CellIndex::valid(frame.source)) return statistics_.frames_invalid.add();
  const std::int32_t row = index_.row(group, frame.source);
  if (row == CellIndex::no_row) return statistics_.frames_unknown_cell.add();
  statistics_.topology_frames.add();
  const TopologyRow before = topology_.row(static_cast<std::size_t>(row));
  if (arrival_ns < before.heard_ns) return;
  TopologyRow& now = topology_.change(static_cast<std::size_t>(row));
  now = topology_row(frame, arrival_ns);
  if (now.closed_port != 0 && now.closed_port != before.closed_port) statistics_.ports_closed.add();
  if (samples_.row(static_cast<std::size_t>(row)).key == 0) {
    samples_.change(static_cast<std::size_t>(row)).key = CellKey{group.number} << 16 | frame.source;
  }
  for (unsigned i = 0; i < RS_PORTS; ++i) {
    if (before.neighbours[i].id == now.neighbours[i].id) continue;
    reference(group, before.neighbours[i], -1, arrival_ns);
    reference(group, now.neighbours[i], +1, arrival_ns);
  }
}

// Counts the cells that report a cell as neighbour: a silent cell that none of them reports any more is gone.
void Driver::reference(CellIndex::Group& group, const ReportedNeighbour& neighbour, int by, std::int64_t now_ns) {
  if (!CellIndex::valid(neighbour.id)) return;
  const std::int32_t row = group.row[neighbour.id];
  if (row == CellIndex::no_row) return;
  std::uint8_t& count = references_[static_cast<std::size_t>(row)];
  if (by < 0 && count == 0) return;
  count = static_cast<std::uint8_t>(std::clamp(count + by, 0, 255));
  const std::int64_t gone_ns = count == 0 ? now_ns : 0;
  if (samples_.row(static_cast<std::size_t>(row)).gone_ns != gone_ns) {
    samples_.change(static_cast<std::size_t>(row)).gone_ns = gone_ns;
  }
}

// The cells of a port send every n-th sample from now on: those last heard there are given time to do so.
void Driver::take_rate_divisor(std::size_t unit_row, const std::uint8_t* record) {
  const std::uint32_t port = rs_record_port(record);
  if (port == 0) return statistics_.frames_invalid.add();
  rs_tick frame;
  rs_tick_unpack(&frame, record);
  UnitPortRow& row = units_.change(unit_row).ports[port];
  const auto divisor = static_cast<std::uint8_t>(std::max(frame.rate_divisor, 1U));
  if (row.rate_divisor == divisor) return;
  row.rate_divisor = divisor;
  const std::size_t way = unit_row << 4 | port;
  for (std::size_t cell = 0; cell < arrival_port_.size(); ++cell) {
    if (arrival_port_[cell] == way && samples_.row(cell).seen) samples_.change(cell).rate_divisor = divisor & 0xF;
  }
}

void Driver::take_reply(CellIndex::Group& group, UnitRow& unit, const std::uint8_t* record, std::int64_t arrival_ns) {
  rs_reply frame;
  rs_reply_unpack(&frame, record);
  if (frame.source == RS_ID_SECTION_UNIT) {
    // A section unit's own tells the last command it passed on, perhaps of another host or of an earlier run.
    const auto counter = static_cast<std::uint16_t>(frame.counter);
    unit.version = static_cast<std::uint8_t>(frame.version);
    if (command_counter_ < 0) counter_known_ns_ = arrival_ns;
    if (command_counter_ < 0 || static_cast<std::int16_t>(counter - command_counter_) > 0) command_counter_ = counter;
    return;
  }
  if (!CellIndex::valid(frame.source)) return statistics_.frames_invalid.add();
  statistics_.reply_frames.add();
  const Sent& sent = sent_[frame.counter % sent_.size()];
  const Reply reply{.heard_ns = arrival_ns,
                    .group = group.number,
                    .source = static_cast<std::uint16_t>(frame.source),
                    .operation = static_cast<std::uint8_t>(frame.operation),
                    .status = static_cast<std::uint8_t>(frame.status),
                    .version = static_cast<std::uint8_t>(frame.version),
                    .ticket = sent.counter == frame.counter ? sent.ticket : 0,
                    .index = static_cast<std::uint16_t>(frame.index),
                    .value_high = static_cast<std::uint16_t>(frame.value_high),
                    .value = frame.value_low};
  if (!replies_.push(reply)) statistics_.replies_dropped.add();
}

}  // namespace robotskin::driver
