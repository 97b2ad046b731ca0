// SPDX-License-Identifier: Apache-2.0
// Host-built cells, wired to each other and to lines: the firmware of a chip, stepped in the order of its events.
//
// Time is given to it. Each cell acts at the time at which it wanted to, so however late it is called, all cells of one
// side agree; only what comes over lines comes late.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <queue>
#include <span>
#include <vector>

#include "robotskin/cell.h"
#include "robotskin/commissioning.h"
#include "serial/cell_sensors.hpp"
#include "serial/unit_side.hpp"

namespace robotskin::serial {

// What is at a cell's port: a port of another cell, a line, or nothing.
struct WireEnd {
  std::int32_t cell = -1;
  std::uint8_t port = 0;  // 1 to 4, of that cell
  std::int32_t line = -1;
};

using CellKeys = std::array<std::uint8_t, RS_CELL_KEYS_BYTES>;

struct HostCell {
  std::uint32_t uid = 1;  // serial number
  std::uint16_t id = 0;   // kept in its flash; 0: the section unit names it
  std::uint32_t random = 1;
  std::array<WireEnd, RS_PORTS> ends;
  std::optional<CellKeys> keys = {};  // its own, in place of those that come from the skin's secret
  bool factory = false;               // it has no keys yet, and waits for them at a line
};

class CellSide {
 public:
  class Outward {
   public:
    virtual ~Outward() = default;
    virtual void frame(std::size_t line, FrameBytes frame, std::int64_t now_ns) = 0;
  };

  // `key`: the skin's secret; none: cells without keys of their own authenticate nothing.
  CellSide(std::vector<HostCell> cells, std::optional<CellKey> key, CellSensors& sensors, Outward& outward,
           std::int64_t now_ns);

  // From a line; a line that no port names takes nothing.
  void frame(std::size_t line, FrameBytes frame, std::int64_t now_ns);
  // Does what is due; when to come again.
  std::int64_t advance(std::int64_t now_ns);

  // The keys that a cell without any was given. It tells that it has them once `note_kept` says that they are stored
  // for good, and runs when its line has been still for a moment.
  const CellKeys* given_keys(std::size_t cell) const;
  void note_kept(std::size_t cell);

  std::size_t cell_count() const { return cells_.size(); }
  const rs_cell& state(std::size_t cell) const { return cells_.at(cell).state; }
  std::uint64_t samples() const { return samples_; }  // taken so far

 private:
  struct Cell {
    HostCell made;
    rs_cell state{};
    std::array<std::uint8_t, RS_FLASH_BYTES> flash;
    std::array<const std::uint8_t*, RS_PORTS> sending{};
    std::array<std::int64_t, RS_PORTS> out_ns;
    std::int64_t due_ns = never;
    std::uint32_t sample_us = 0, clock_start_us = 0;
    bool sampling = false;
    rs_sample sample{};
    std::optional<rs_commissioning> commissioning;  // while it has no keys
    bool stored = false;
  };
  struct Event {
    std::int64_t time_ns;
    std::uint64_t order;
    std::uint32_t cell, port;  // port RS_PORTS: the cell's alarm
    bool operator>(const Event& other) const {
      return time_ns != other.time_ns ? time_ns > other.time_ns : order > other.order;
    }
  };

  static std::uint32_t clock_us(const Cell& cell, std::int64_t now_ns) {
    return cell.clock_start_us + static_cast<std::uint32_t>(now_ns / 1000);
  }
  void boot(std::size_t index, std::int64_t now_ns);
  void step(std::size_t index, const rs_input& input, std::int64_t now_ns);
  void finish(std::size_t index, std::size_t port, std::int64_t now_ns);
  void wake(std::size_t index, std::int64_t now_ns);
  void arrive(std::size_t index, unsigned port, const std::uint8_t* frame, std::int64_t now_ns);
  void commission(Cell& cell, unsigned port, const std::uint8_t* frame, std::int64_t now_ns);

  std::vector<Cell> cells_;
  std::optional<CellKey> key_;
  CellSensors& sensors_;
  Outward& outward_;
  std::vector<WireEnd> line_ends_;  // by line
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
  std::uint64_t order_ = 0, samples_ = 0;
};

}  // namespace robotskin::serial
