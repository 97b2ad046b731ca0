// SPDX-License-Identifier: Apache-2.0
// The datagrams of section units with many cells in clock mode, without simulating cells: load for driver and tests.
//
// Format, batching, sequence numbers, answering and tags are those of a section unit (datagram.h, section_unit.h): a
// frame waits at most a millisecond for its datagram to fill. Values are drawn; `sent` tells what went out last.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "driver/keyed_hash.hpp"
#include "driver/sample.hpp"

namespace robotskin::lab {

struct TrafficOptions {
  std::size_t cells = 1260;
  unsigned rate_hz = 250;  // frames of each cell a second; divides 1000
  unsigned records_per_datagram = RS_DATAGRAM_RECORDS_MAX;
  std::optional<driver::Key> key;  // with it nothing is sent before a host has been heard
  std::uint64_t seed = 1;
  bool event_mode = false;
};

class Traffic {
 public:
  static constexpr std::size_t cells_per_unit = 5 * RS_CELLS_PER_PORT;
  static constexpr std::size_t units_per_group = 16;

  // Throws std::invalid_argument for a rate that does not divide 1000 or a datagram of no records or too many.
  explicit Traffic(const TrafficOptions& options);

  std::vector<driver::CellKey> keys() const;

  // Takes a datagram of the host.
  void hear(std::span<const std::uint8_t> datagram);

  // Whether a host listens to every unit and, with a key, has answered its session.
  bool connected() const;

  using Sink = std::function<void(std::span<const std::uint8_t>)>;

  // The millisecond that ends at `now_ns` (section units' clock): frames of the cells whose turn it is.
  void step(std::uint64_t now_ns, const Sink& sink);

  // Sends what still waits for its datagram to fill.
  void flush(std::uint64_t now_ns, const Sink& sink);

  // The last frame of each cell, sent or waiting; only channels, sequence and flags.
  const std::vector<driver::Sample>& sent() const { return sent_; }
  std::uint64_t frames() const { return frames_; }
  std::uint64_t datagrams() const { return datagrams_; }

 private:
  struct Unit {
    std::uint16_t group = 0;
    std::uint8_t number = 0;
    std::uint32_t session = 0;
    std::uint32_t sequence = 0;
    std::uint32_t host_session = 0;
    bool host_heard = false;
    std::vector<std::uint8_t> records;       // waiting
    std::vector<std::uint64_t> arrivals_ns;  // of the waiting records
  };

  void sample(std::size_t cell, std::uint64_t arrival_ns, std::uint8_t* record);
  void send(Unit& unit, rs_datagram_kind kind, std::size_t records, std::uint64_t now_ns, const Sink& sink);
  std::uint64_t draw();

  TrafficOptions options_;
  std::optional<driver::KeyedHash> hash_;
  std::vector<driver::Sample> sent_;
  std::vector<Unit> units_;
  std::vector<std::uint8_t> datagram_;
  std::uint64_t random_;
  std::uint64_t step_ = 0;
  std::uint64_t frames_ = 0, datagrams_ = 0;
};

struct TrafficReport {
  std::uint64_t frames = 0, datagrams = 0;
  double seconds = 0;
  double late_ms_max = 0;  // how far the sender fell behind its own clock
  double cpu_seconds = 0;
  std::uint64_t refused = 0;  // datagrams the system did not take
};

// Sends traffic over UDP to `host`:`port` in steps of a millisecond, for `seconds` from the moment a host listens; it
// waits for one at most `patience_s`. Throws std::runtime_error if none comes.
// `prepared`: all datagrams are made and tagged before the first one leaves, for loads beyond what can be made while
// they are sent; that takes 21 bytes a frame, and their clock lags by the time that it took.
TrafficReport send_traffic(const TrafficOptions& options, const std::string& host, std::uint16_t port,
                           const std::string& local_host, std::uint16_t local_port, double seconds, double patience_s,
                           bool realtime, bool prepared = false);

}  // namespace robotskin::lab
