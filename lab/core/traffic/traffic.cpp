// SPDX-License-Identifier: Apache-2.0
#include "traffic/traffic.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "driver/clock.hpp"
#include "driver/udp_socket.hpp"
#include "robotskin/datagram.h"

namespace robotskin::lab {
namespace {

constexpr std::uint64_t step_ns = 1'000'000;

// Clocks of section units run a tenth of a percent fast here, so that a load is never a hair below what it is called.
constexpr std::int64_t paced_step_ns = 999'000;

// Datagrams one after the other in memory, sent many a system call.
class Outbox {
 public:
  void reserve(std::size_t frames) { bytes_.reserve(frames * (RS_DATAGRAM_RECORD_BYTES + 2)); }

  void add(std::span<const std::uint8_t> datagram) {
    starts_.push_back(bytes_.size());
    bytes_.insert(bytes_.end(), datagram.begin(), datagram.end());
  }

  void clear() {
    starts_.clear();
    bytes_.clear();
  }

  std::size_t size() const { return starts_.size(); }

  // How many of the datagrams from `first` until before `last` the system did not take.
  std::size_t send(const driver::UdpSocket& socket, const driver::Address& to, std::size_t first, std::size_t last) {
    const std::size_t count = last - first;
    vectors_.resize(count);
    messages_.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t start = starts_[first + i];
      const std::size_t end = first + i + 1 < starts_.size() ? starts_[first + i + 1] : bytes_.size();
      vectors_[i] = {&bytes_[start], end - start};
      messages_[i] = {};
      messages_[i].msg_hdr.msg_iov = &vectors_[i];
      messages_[i].msg_hdr.msg_iovlen = 1;
      messages_[i].msg_hdr.msg_name = const_cast<sockaddr_storage*>(&to.storage);
      messages_[i].msg_hdr.msg_namelen = to.length;
    }
    return count - socket.send_many(messages_);
  }

 private:
  std::vector<std::uint8_t> bytes_;
  std::vector<std::size_t> starts_;
  std::vector<iovec> vectors_;
  std::vector<mmsghdr> messages_;
};

}  // namespace

Traffic::Traffic(const TrafficOptions& options) : options_(options), sent_(options.cells), random_(options.seed) {
  if (options.rate_hz == 0 || 1000 % options.rate_hz != 0) {
    throw std::invalid_argument("a rate of " + std::to_string(options.rate_hz) + " Hz does not divide 1000 Hz");
  }
  if (options.records_per_datagram == 0 || options.records_per_datagram > RS_DATAGRAM_RECORDS_MAX) {
    throw std::invalid_argument(std::to_string(options.records_per_datagram) +
                                " records a datagram: choose from 1 to " + std::to_string(RS_DATAGRAM_RECORDS_MAX));
  }
  if (options.key) hash_.emplace(*options.key);
  units_.resize((options.cells + cells_per_unit - 1) / cells_per_unit);
  for (std::size_t i = 0; i < units_.size(); ++i) {
    units_[i].group = static_cast<std::uint16_t>(i / units_per_group);
    units_[i].number = static_cast<std::uint8_t>(i % units_per_group);
    units_[i].session = static_cast<std::uint32_t>(draw()) | 1U;
  }
  datagram_.resize(RS_DATAGRAM_BYTES_MAX);
}

std::uint64_t Traffic::draw() {  // splitmix64
  std::uint64_t z = random_ += 0x9E3779B97F4A7C15U;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31);
}

std::vector<driver::CellKey> Traffic::keys() const {
  constexpr std::size_t cells_per_group = cells_per_unit * units_per_group;
  std::vector<driver::CellKey> keys;
  for (std::size_t i = 0; i < options_.cells; ++i) {
    keys.push_back(static_cast<driver::CellKey>(i / cells_per_group << 16 | (i % cells_per_group + RS_ID_FIRST)));
  }
  return keys;
}

void Traffic::hear(std::span<const std::uint8_t> datagram) {
  rs_datagram_header header;
  const auto size = static_cast<std::uint32_t>(datagram.size());
  if (rs_datagram_header_unpack(&header, datagram.data(), size) != RS_DATAGRAM_OK) return;
  if (hash_) {
    if ((header.flags & RS_DATAGRAM_KEYED) == 0) return;
    const std::size_t signed_bytes = datagram.size() - RS_DATAGRAM_TAG_BYTES;
    if (!hash_->matches(datagram.first(signed_bytes), datagram.data() + signed_bytes)) return;
  }
  for (Unit& unit : units_) {
    if (unit.group != header.group) continue;
    if (header.unit != RS_UNIT_ALL && header.unit != unit.number) continue;
    unit.host_heard = true;
    if (!hash_ || header.answering == unit.session) unit.host_session = header.session;
  }
}

bool Traffic::connected() const {
  return std::ranges::all_of(units_, [](const Unit& unit) { return unit.host_session != 0; });
}

void Traffic::sample(std::size_t cell, std::uint64_t arrival_ns, std::uint8_t* record) {
  driver::Sample& sent = sent_[cell];
  const std::uint64_t bits = draw(), more = draw();
  rs_clock frame{};
  frame.type = options_.event_mode ? RS_TYPE_event : RS_TYPE_clock;
  frame.source = static_cast<std::uint32_t>(cell % (cells_per_unit * units_per_group) + RS_ID_FIRST);
  frame.sequence = static_cast<std::uint8_t>(sent.sequence + 1);
  frame.ttl = RS_TTL_START;
  frame.sample_tick = arrival_ns / step_ns & 0xF;
  frame.sample_phase = static_cast<std::uint32_t>(arrival_ns % step_ns * 64 / step_ns);
  frame.proximity = bits & 0xFFFF;
  frame.force_1 = bits >> 16 & 0x3FF;
  frame.force_2 = bits >> 26 & 0x3FF;
  frame.force_3 = bits >> 36 & 0x3FF;
  frame.acceleration_x = static_cast<std::int32_t>(more & 0x1FF) - 256;
  frame.acceleration_y = static_cast<std::int32_t>(more >> 9 & 0x1FF) - 256;
  frame.acceleration_z = static_cast<std::int32_t>(more >> 18 & 0x1FF) - 256;
  frame.temperature_1 = static_cast<std::int32_t>(more >> 27 & 0x3F);
  frame.temperature_2 = static_cast<std::int32_t>(more >> 33 & 0x3FF);
  driver::take_channels(sent, frame);
  sent.sequence = static_cast<std::uint8_t>(frame.sequence);
  sent.seen = true;
  rs_clock_pack(record, &frame);
}

void Traffic::send(Unit& unit, rs_datagram_kind kind, std::size_t records, std::uint64_t now_ns, const Sink& sink) {
  rs_datagram_header header{};
  header.kind = static_cast<std::uint8_t>(kind);
  header.flags = hash_ ? RS_DATAGRAM_KEYED : 0;
  header.group = unit.group;
  header.unit = unit.number;
  header.session = unit.session;
  header.sequence = ++unit.sequence;
  header.time_ns = now_ns;
  header.count = static_cast<std::uint16_t>(records);
  header.answering = unit.host_session;
  rs_datagram_header_pack(datagram_.data(), &header);
  std::size_t bytes = RS_DATAGRAM_HEADER_BYTES;
  for (std::size_t i = 0; i < records; ++i, bytes += RS_DATAGRAM_RECORD_BYTES) {
    std::copy_n(&unit.records[i * RS_DATAGRAM_RECORD_BYTES], RS_CONTENT_BYTES, &datagram_[bytes]);
    rs_record_arrival_pack(&datagram_[bytes], 1, static_cast<std::uint32_t>((now_ns - unit.arrivals_ns[i]) / 1000));
  }
  if (hash_) {
    const driver::Tag tag = hash_->tag({datagram_.data(), bytes});
    std::copy(tag.begin(), tag.end(), datagram_.begin() + static_cast<std::ptrdiff_t>(bytes));
    bytes += tag.size();
  }
  unit.records.erase(unit.records.begin(),
                     unit.records.begin() + static_cast<std::ptrdiff_t>(records * RS_DATAGRAM_RECORD_BYTES));
  unit.arrivals_ns.erase(unit.arrivals_ns.begin(), unit.arrivals_ns.begin() + static_cast<std::ptrdiff_t>(records));
  frames_ += records;
  ++datagrams_;
  sink({datagram_.data(), bytes});
}

void Traffic::step(std::uint64_t now_ns, const Sink& sink) {
  const std::size_t turns = 1000 / options_.rate_hz;
  const std::size_t turn = step_++ % turns;
  for (std::size_t u = 0; u < units_.size(); ++u) {
    Unit& unit = units_[u];
    if (unit.host_session == 0) {
      if (unit.host_heard) send(unit, RS_DATAGRAM_KIND_heartbeat, 0, now_ns, sink);
      unit.host_heard = false;
      continue;
    }
    const std::size_t first = u * cells_per_unit;
    const std::size_t last = std::min(first + cells_per_unit, options_.cells);
    // Cells of a turn are spread over its millisecond, as ports deliver them.
    const std::uint64_t spacing_ns = step_ns * turns / cells_per_unit;
    std::uint64_t arrival_ns = now_ns - step_ns;
    for (std::size_t cell = first + turn; cell < last; cell += turns, arrival_ns += spacing_ns) {
      const std::size_t at = unit.records.size();
      unit.records.resize(at + RS_DATAGRAM_RECORD_BYTES);
      sample(cell, arrival_ns, &unit.records[at]);
      unit.arrivals_ns.push_back(arrival_ns);
    }
    while (unit.arrivals_ns.size() >= options_.records_per_datagram) {
      send(unit, RS_DATAGRAM_KIND_frames, options_.records_per_datagram, now_ns, sink);
    }
    // What would be older than a millisecond by the next step does not wait for it.
    if (!unit.arrivals_ns.empty() && now_ns - unit.arrivals_ns.front() > step_ns / 2) {
      send(unit, RS_DATAGRAM_KIND_frames, unit.arrivals_ns.size(), now_ns, sink);
    }
  }
}

void Traffic::flush(std::uint64_t now_ns, const Sink& sink) {
  for (Unit& unit : units_) {
    if (!unit.arrivals_ns.empty()) send(unit, RS_DATAGRAM_KIND_frames, unit.arrivals_ns.size(), now_ns, sink);
  }
}

TrafficReport send_traffic(const TrafficOptions& options, const std::string& host, std::uint16_t port,
                           const std::string& local_host, std::uint16_t local_port, double seconds, double patience_s,
                           bool realtime, bool prepared) {
  using driver::monotonic_ns;
  if (realtime) driver::become_realtime();
  Traffic traffic(options);
  const driver::Address to = driver::Address::resolve(host, port);
  driver::UdpSocket socket(driver::Address::resolve(local_host, local_port, to.storage.ss_family), 1 << 20);
  const auto hear = [&] {
    while (const std::size_t count = socket.receive()) {
      for (std::size_t i = 0; i < count; ++i) traffic.hear(socket.datagram(i));
    }
  };
  // A section unit does not speak either while no host listens.
  const std::int64_t give_up_ns = monotonic_ns() + static_cast<std::int64_t>(patience_s * 1e9);
  for (; !traffic.connected(); hear()) {
    if (monotonic_ns() > give_up_ns) throw std::runtime_error("no host has sent a keep-alive");
    socket.wait(10'000'000);
    hear();
    if (traffic.connected()) break;
    traffic.step(static_cast<std::uint64_t>(monotonic_ns()),
                 [&](std::span<const std::uint8_t> datagram) { socket.send(datagram, to); });
  }

  const auto steps = static_cast<std::size_t>(seconds * 1e9 / static_cast<double>(paced_step_ns));
  Outbox outbox;
  const auto fill = [&](std::int64_t now_ns) {
    traffic.step(static_cast<std::uint64_t>(now_ns), [&](std::span<const std::uint8_t> bytes) { outbox.add(bytes); });
  };
  std::vector<std::size_t> filled;  // datagrams until each step, if they are prepared
  if (prepared) {
    outbox.reserve(steps * options.cells * options.rate_hz / 1000);
    const std::int64_t clock_ns = monotonic_ns();
    for (std::size_t step = 1; step <= steps; ++step) {
      fill(clock_ns + static_cast<std::int64_t>(step) * paced_step_ns);
      filled.push_back(outbox.size());
    }
  }

  TrafficReport report;
  const double cpu_before = static_cast<double>(driver::clock_ns(CLOCK_PROCESS_CPUTIME_ID)) * 1e-9;
  const std::int64_t start_ns = monotonic_ns();
  std::size_t sent = 0;
  for (std::size_t step = 1; step <= steps; ++step) {
    const std::int64_t due_ns = start_ns + static_cast<std::int64_t>(step) * paced_step_ns;
    const timespec until{due_ns / 1'000'000'000, due_ns % 1'000'000'000};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
    report.late_ms_max = std::max(report.late_ms_max, static_cast<double>(monotonic_ns() - due_ns) * 1e-6);
    if (step % 16 == 0) hear();
    if (prepared) {
      report.refused += outbox.send(socket, to, sent, filled[step - 1]);
      sent = filled[step - 1];
    } else {
      outbox.clear();
      fill(monotonic_ns());
      report.refused += outbox.send(socket, to, 0, outbox.size());
    }
  }
  report.frames = traffic.frames();
  report.datagrams = traffic.datagrams();
  report.seconds = static_cast<double>(monotonic_ns() - start_ns) * 1e-9;
  report.cpu_seconds = static_cast<double>(driver::clock_ns(CLOCK_PROCESS_CPUTIME_ID)) * 1e-9 - cpu_before;
  return report;
}

}  // namespace robotskin::lab
