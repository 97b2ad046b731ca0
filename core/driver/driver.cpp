#include "driver/driver.hpp"

#include <algorithm>
#include <cstdlib>

namespace robotskin::driver {
namespace {

constexpr std::size_t departures_max = 8192;

// A section unit's clock may say anything: what it calls older than this is no more than this old, and never to come.
constexpr std::int64_t oldest_ns = 60'000'000'000;

constexpr std::int64_t commands_patience_ns = 1'000'000'000;

// Frames of one cell this close in time are ordered by their sequence number, others by their arrival: the number
// wraps at 256, and a restarted cell begins anywhere.
constexpr std::int64_t sequence_ordered_ns = 100'000'000;

}  // namespace

Driver::Driver(const Options& options)
    : keys_(options.keys),
      index_(options.keys, options.spare_cells, options.spare_groups),
      samples_(index_.capacity()),
      topology_(index_.capacity()),
      units_(units_max),
      references_(index_.capacity(), 0),
      heard_(index_.capacity(), 0),
      way_(index_.capacity(), 0),
      links_(units_max),
      unit_names_(units_max),
      random_(options.session_seed),
      calendar_ns_(options.calendar_ns) {
  if (options.key) hash_.emplace(*options.key);
  departures_ns_.reserve(departures_max);
  for (std::size_t i = 0; i < options.keys.size(); ++i) samples_.change(i).key = options.keys[i];
  own_sessions_.fill(0);
  strangers_.reserve(units_max);
  draw_session();
}

void Driver::draw_session() {
  do {
    // splitmix64
    std::uint64_t z = random_ += 0x9E3779B97F4A7C15U;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
    session_ = static_cast<std::uint32_t>((z ^ (z >> 31)) >> 32);
  } while (session_ == 0 || answers_us(session_));
  std::rotate(own_sessions_.begin(), own_sessions_.end() - 1, own_sessions_.end());
  own_sessions_[0] = session_;
  sequence_ = 0;
  keep_alive_due_ = true;
}

bool Driver::answers_us(std::uint32_t session) const {
  return session != 0 && std::find(own_sessions_.begin(), own_sessions_.end(), session) != own_sessions_.end();
}

std::optional<std::size_t> Driver::find_unit(std::uint16_t section_unit, std::uint8_t unit) {
  const std::uint32_t name = std::uint32_t{section_unit} << 8 | unit;
  for (std::size_t i = 0; i < unit_count_; ++i) {
    if (unit_names_[i] == name) return i;
  }
  return std::nullopt;
}

// Notes a unit with a right tag that does not answer us, so that the next downlink answers it.
void Driver::meet(const rs_datagram_header& header) {
  last_heard_ = {header.section_unit, header.unit, true};
  for (Stranger& stranger : strangers_) {
    if (stranger.unit.section_unit != header.section_unit || stranger.unit.unit != header.unit) continue;
    stranger.session = header.session;
    stranger.due = true;
    return;
  }
  if (strangers_.size() < units_max) strangers_.push_back({last_heard_, header.session, true});
}

// Decides whether a datagram is fresh. Changes nothing of the known units unless it is.
Verdict Driver::admit(const rs_datagram_header& header, std::int64_t now_ns, std::size_t* unit) {
  if (hash_ && !answers_us(header.answering)) {
    meet(header);
    return Verdict::unanswering;
  }
  std::optional<std::size_t> known = find_unit(header.section_unit, header.unit);
  const bool restarted = known && links_[*known].session != header.session;
  if (!known || restarted) {
    if (hash_ && header.answering != session_) {
      meet(header);
      return Verdict::unanswering;
    }
    if (!known && unit_count_ == units_max) return Verdict::unit_refused;
    if (restarted) {
      Link& link = links_[*known];
      if (std::find(link.ended.begin(), link.ended.end(), header.session) != link.ended.end()) return Verdict::replayed;
      link.ended[link.next_ended++ % link.ended.size()] = link.session;
      link.window.reset();
      link.clock.reset();
      link.missing_counted = 0;
      link.dropped = 0;
      draw_session();
    } else {
      known = unit_count_++;
      unit_names_[*known] = std::uint32_t{header.section_unit} << 8 | header.unit;
      UnitRow& row = units_.change(*known);
      row.section_unit = header.section_unit;
      row.unit = header.unit;
    }
    links_[*known].session = header.session;
    statistics_.sessions.add();
    keep_alive_due_ = true;
  }
  Link& link = links_[*known];
  switch (link.window.take(header.sequence)) {
    case SequenceWindow::Verdict::seen:
      return Verdict::duplicated;
    case SequenceWindow::Verdict::too_old:
      return Verdict::replayed;
    case SequenceWindow::Verdict::fresh:
      break;
  }
  link.clock.take(header.time_ns, now_ns);
  *unit = *known;
  return Verdict::accepted;
}

// Has the rows that the records name fetched while the tag is computed, which needs no memory.
void Driver::prefetch(const rs_datagram_header& header, std::span<const std::uint8_t> datagram) {
  const CellIndex::Group* group = index_.find(header.section_unit);
  if (group == nullptr) return;
  const std::uint8_t* record = datagram.data() + RS_DATAGRAM_HEADER_BYTES;
  for (unsigned i = 0; i < header.count; ++i, record += RS_DATAGRAM_RECORD_BYTES) {
    rs_clock frame;
    rs_clock_unpack(&frame, record);
    if (!CellIndex::valid(frame.source)) continue;
    const std::int32_t row = group->row[frame.source];
    if (row != CellIndex::nobody) samples_.prefetch(static_cast<std::size_t>(row));
  }
}

Verdict Driver::handle(std::span<const std::uint8_t> datagram, std::int64_t now_ns) {
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
  if (hash_) {
    if ((header.flags & RS_DATAGRAM_KEYED) == 0) return verdict(Verdict::unauthenticated);
    const std::size_t signed_bytes = datagram.size() - RS_DATAGRAM_TAG_BYTES;
    if (!hash_->matches(datagram.first(signed_bytes), datagram.data() + signed_bytes)) {
      return verdict(Verdict::unauthenticated);
    }
  }
  CellIndex::Group* group = index_.group(header.section_unit);
  if (group == nullptr) return verdict(Verdict::foreign);
  std::size_t unit_row = 0;
  const Verdict fresh = admit(header, now_ns, &unit_row);
  if (fresh != Verdict::accepted) return verdict(fresh);

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
  last_heard_ = {header.section_unit, header.unit, false};
  return verdict(Verdict::accepted);
}

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
    case RS_TYPE_topology:
      return take_topology(group, unit, record, arrival_ns);
    case RS_TYPE_reply:
      return take_reply(group, record, arrival_ns);
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
    case RS_TYPE_torque:
      return statistics_.torque_frames.add();
    default:
      return statistics_.frames_invalid.add();
  }
}

void Driver::take_reply(CellIndex::Group& group, const std::uint8_t* record, std::int64_t arrival_ns) {
  rs_reply frame;
  rs_reply_unpack(&frame, record);
  if (frame.source == RS_ID_SECTION_UNIT) {
    // A section unit's own tells the last command it passed on, perhaps of another host or of an earlier run.
    const auto counter = static_cast<std::uint16_t>(frame.counter);
    if (command_counter_ < 0) counter_known_ns_ = arrival_ns;
    if (command_counter_ < 0 || static_cast<std::int16_t>(counter - command_counter_) > 0) command_counter_ = counter;
    return;
  }
  if (!CellIndex::valid(frame.source)) return statistics_.frames_invalid.add();
  statistics_.reply_frames.add();
  const Sent& sent = sent_[frame.counter % sent_.size()];
  const Reply reply{.heard_ns = arrival_ns,
                    .section_unit = group.section_unit,
                    .source = static_cast<std::uint16_t>(frame.source),
                    .operation = static_cast<std::uint8_t>(frame.operation),
                    .status = static_cast<std::uint8_t>(frame.status),
                    .ticket = sent.counter == frame.counter ? sent.ticket : 0,
                    .index = static_cast<std::uint16_t>(frame.index),
                    .value_high = static_cast<std::uint16_t>(frame.value_high),
                    .value = frame.value_low};
  if (!replies_.push(reply)) statistics_.replies_dropped.add();
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
  for (std::size_t cell = 0; cell < way_.size(); ++cell) {
    if (way_[cell] == way && samples_.row(cell).seen) samples_.change(cell).rate_divisor = divisor & 0xF;
  }
}

// Whether a sample is newer than all before it. One that is not has been overtaken, or has come before: after a failure
// cells send again what may have been lost, and say so (`replayed`), no more than 16 ms after it was sampled.
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
  if (known && (close || frame.replayed != 0)) {
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
  if (row == CellIndex::nobody) return statistics_.frames_unknown_cell.add();
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
  const std::array<std::int16_t, 3> acceleration = sample.acceleration;
  take_channels(sample, frame);
  sample.key = CellKey{group.section_unit} << 16 | frame.source;
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
  way_[static_cast<std::size_t>(row)] = static_cast<std::uint16_t>(unit_row << 4 | port);
}

void Driver::count_events(const Sample& before, const rs_clock& frame) {
  Sample now = before;
  take_channels(now, frame);
  const auto changed = [](const auto& a, const auto& b) {
    std::uint64_t count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) count += a[i] != b[i];
    return count;
  };
  statistics_.events_proximity.add(before.proximity != now.proximity);
  statistics_.events_force.add(changed(before.force, now.force));
  statistics_.events_acceleration.add(changed(before.acceleration, now.acceleration));
  statistics_.events_temperature.add(changed(before.temperature, now.temperature));
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
  if (row == CellIndex::nobody) return statistics_.frames_unknown_cell.add();
  statistics_.topology_frames.add();
  const TopologyRow before = topology_.row(static_cast<std::size_t>(row));
  if (arrival_ns < before.heard_ns) return;
  TopologyRow& now = topology_.change(static_cast<std::size_t>(row));
  now = topology_row(frame, arrival_ns);
  if (samples_.row(static_cast<std::size_t>(row)).key == 0) {
    samples_.change(static_cast<std::size_t>(row)).key = CellKey{group.section_unit} << 16 | frame.source;
  }
  for (unsigned i = 0; i < RS_PORTS; ++i) {
    if (before.neighbours[i].id == now.neighbours[i].id) continue;
    reference(group, before.neighbours[i], -1, arrival_ns);
    reference(group, now.neighbours[i], +1, arrival_ns);
  }
}

// Counts who reports a cell as neighbour: a cell whom nobody reports any more, and who is silent, is gone.
void Driver::reference(CellIndex::Group& group, const ReportedNeighbour& neighbour, int by, std::int64_t now_ns) {
  if (!CellIndex::valid(neighbour.id)) return;
  const std::int32_t row = group.row[neighbour.id];
  if (row == CellIndex::nobody) return;
  std::uint8_t& count = references_[static_cast<std::size_t>(row)];
  if (by < 0 && count == 0) return;
  count = static_cast<std::uint8_t>(std::clamp(count + by, 0, 255));
  const std::int64_t gone_ns = count == 0 ? now_ns : 0;
  if (samples_.row(static_cast<std::size_t>(row)).gone_ns != gone_ns) {
    samples_.change(static_cast<std::size_t>(row)).gone_ns = gone_ns;
  }
}

void Driver::publish(std::int64_t now_ns) {
  samples_.publish(now_ns);
  topology_.publish(now_ns);
  units_.publish(now_ns);
  statistics_.publications.add();
  for (const std::int64_t departure_ns : departures_ns_) statistics_.latency.take(now_ns - departure_ns);
  departures_ns_.clear();
}

std::optional<std::uint32_t> Driver::command(Command command) {
  command.ticket = ticket_ + 1;
  if (!commands_.push(command)) return std::nullopt;
  return ++ticket_;
}

// Completes and hands over the datagram whose records stand in out_.
void Driver::send(rs_datagram_kind kind, std::uint16_t count, const Recipient& to, std::uint32_t answering,
                  std::int64_t now_ns, const Sink& sink) {
  rs_datagram_header header{};
  header.kind = static_cast<std::uint8_t>(kind);
  header.flags = hash_ ? RS_DATAGRAM_KEYED : 0;
  header.section_unit = to.section_unit;
  header.unit = to.unit;
  header.session = session_;
  header.sequence = ++sequence_;
  header.time_ns = static_cast<std::uint64_t>(now_ns + calendar_ns_);
  header.count = count;
  header.answering = answering;
  rs_datagram_header_pack(out_.data(), &header);
  std::size_t bytes = RS_DATAGRAM_HEADER_BYTES + std::size_t{header.count} * RS_DATAGRAM_RECORD_BYTES;
  if (hash_) {
    const Tag tag = hash_->tag({out_.data(), bytes});
    std::copy(tag.begin(), tag.end(), out_.begin() + static_cast<std::ptrdiff_t>(bytes));
    bytes += tag.size();
  }
  sink(to, {out_.data(), bytes});
}

void Driver::downlink(std::int64_t now_ns, const Sink& sink) {
  for (Stranger& stranger : strangers_) {
    if (!stranger.due) continue;
    stranger.due = false;
    send(RS_DATAGRAM_KIND_keep_alive, 0, stranger.unit, stranger.session, now_ns, sink);
    statistics_.keep_alives_sent.add();
  }
  if (keep_alive_due_ || now_ns - keep_alive_ns_ >= RS_KEEP_ALIVE_MS * std::int64_t{1'000'000}) {
    keep_alive_due_ = false;
    keep_alive_ns_ = now_ns;
    keep_alive(now_ns, sink);
  }
  send_commands(now_ns, sink);
}

void Driver::keep_alive(std::int64_t now_ns, const Sink& sink) {
  // With answering 0 it wakes units that have not been heard yet, or have restarted.
  for (const CellIndex::Group& group : index_.groups()) {
    send(RS_DATAGRAM_KIND_keep_alive, 0, {group.section_unit, RS_UNIT_ALL}, 0, now_ns, sink);
    statistics_.keep_alives_sent.add();
  }
  for (std::size_t i = 0; i < unit_count_; ++i) {
    const UnitRow& unit = units_.row(i);
    if (now_ns - unit.heard_ns > unit_silent_ns) continue;
    send(RS_DATAGRAM_KIND_keep_alive, 0, {unit.section_unit, unit.unit}, unit.session, now_ns, sink);
    statistics_.keep_alives_sent.add();
  }
}

// A command goes out when its counter can be known and, within a second, each group has been heard.
bool Driver::ready_to_command(std::int64_t now_ns) {
  if (command_counter_ < 0) return false;
  if (now_ns - counter_known_ns_ > commands_patience_ns) return true;
  return std::ranges::all_of(index_.groups(), [this](const CellIndex::Group& group) {
    for (std::size_t i = 0; i < unit_count_; ++i) {
      if (unit_names_[i] >> 8 == group.section_unit) return true;
    }
    return false;
  });
}

void Driver::send_commands(std::int64_t now_ns, const Sink& sink) {
  const auto send_to_units = [&](rs_datagram_kind kind, std::uint16_t section_unit, std::uint8_t which) {
    for (std::size_t i = 0; i < unit_count_; ++i) {
      const UnitRow& unit = units_.row(i);
      if (unit.section_unit != section_unit || (which != RS_UNIT_ALL && which != unit.unit)) continue;
      send(kind, 1, {unit.section_unit, unit.unit}, unit.session, now_ns, sink);
    }
  };
  std::uint8_t* record = out_.data() + RS_DATAGRAM_HEADER_BYTES;
  while (ready_to_command(now_ns)) {
    const std::optional<Command> command = commands_.pop();
    if (!command) break;
    command_counter_ = static_cast<std::uint16_t>(command_counter_ + 1);
    const auto counter = static_cast<std::uint16_t>(command_counter_);
    sent_[counter % sent_.size()] = {command->ticket, counter};
    rs_command frame{};
    frame.type = RS_TYPE_command;
    frame.target = command->target;
    frame.operation = command->operation;
    frame.counter = counter;
    frame.index = command->index;
    frame.value_low = command->value;
    rs_command_pack(record, &frame);
    rs_record_arrival_pack(record, 0, 0);
    send_to_units(RS_DATAGRAM_KIND_inject, command->section_unit, RS_UNIT_ALL);
    statistics_.commands_sent.add();
  }
  while (const std::optional<Power> power = powers_.pop()) {
    std::fill_n(record, RS_DATAGRAM_RECORD_BYTES, std::uint8_t{0});
    record[0] = power->on ? 1 : 0;
    rs_record_arrival_pack(record, power->port, 0);
    send_to_units(RS_DATAGRAM_KIND_power, power->section_unit, power->unit);
  }
}

}  // namespace robotskin::driver
