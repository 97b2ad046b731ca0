// SPDX-License-Identifier: Apache-2.0
// What the network is made of; known to its own sources only.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>

#include "world/network/network.hpp"

namespace robotskin::world {

inline constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();
inline constexpr std::int64_t ethernet_ns = 200'000;   // between two section units
inline constexpr std::int64_t restart_ns = 1'000'000;  // of a cell that asks for it
inline constexpr double frame_us = 1e6 * double{RS_FRAME_BYTES * RS_LINK_BITS_PER_BYTE} / double{RS_LINK_BAUD};

// Streams of random numbers, each of its own for a cell, wire or unit.
enum NetworkPurpose : std::uint64_t {
  purpose_clock = 11,
  purpose_wire = 12,
  purpose_boot = 13,
  purpose_session = 14,
  purpose_unit_clock = 15,
  purpose_act = 16,
  purpose_ethernet = 17
};

// Kinds of events; the other bits say which one. Else: a cell wakes.
inline constexpr std::uint32_t wire_event = 0x80000000U, unit_event = 0x40000000U, letter_event = 0x20000000U;

// Why a wire carries nothing in one direction.
enum : std::uint8_t { severed_by_cut = 1, severed_as_late = 2 };

struct alignas(64) Network::Cell {
  enum class Power : std::uint8_t { off, starting, on, dead, zombie };

  // What every event needs, in one line of the cache.
  Power power = Power::off;
  bool sampling = false;
  std::uint8_t waiting = 0, sent = 0;  // of the last output, and for the next input: cell.h
  std::uint32_t sample_us = 0;
  std::uint32_t clock_start_us = 0;
  std::uint32_t queue_peak = 0;
  double us_per_ns = 1e-3, ns_per_us = 1e3;
  std::int64_t due_ns = never, scheduled_ns = never;
  std::int64_t slow_ns = 0;  // each wake-up and frame comes so much later
  std::int64_t free_ns = 0;  // the processor is busy until then

  alignas(64) rs_cell state{};
  std::int64_t booted_ns = -1;
  std::uint64_t boot_key = 0, boots = 0;
  rs_sample sample{};
  rs_contribution contribution{};
  std::uint8_t flash[RS_FLASH_BYTES] = {};

  std::uint32_t clock_us(std::int64_t time_ns) const {
    return clock_start_us +
           static_cast<std::uint32_t>(static_cast<std::int64_t>(static_cast<double>(time_ns) * us_per_ns));
  }
};

// What stands between a cell's lines and its processor.
struct Network::Board {
  struct Frame {
    std::int64_t time_ns;  // one that goes: not before that on its wire; one that comes: since then
    alignas(4) std::array<std::uint8_t, RS_FRAME_BYTES> bytes;
  };
  // Blocks for frames that come, which all ports share.
  class Blocks {
   public:
    std::size_t count() const { return count_; }
    bool empty() const { return count_ == 0; }
    std::uint32_t ports() const;  // bit p: a frame of port p waits
    Frame& push(std::size_t port);
    Frame pop(std::size_t port);  // the oldest of that port, of which there must be one

   private:
    std::array<Frame, board_frames_in> frame_;
    std::array<std::uint8_t, board_frames_in> port_{};  // the oldest first
    std::uint8_t count_ = 0;
  };
  template <std::size_t Size>
  struct Ring {
    std::array<Frame, Size> frame;
    std::uint8_t first = 0, count = 0;

    bool full() const { return count == Size; }
    Frame& front() { return frame[first]; }
    Frame& push() { return frame[(first + count++) % Size]; }
    void pop() {
      first = static_cast<std::uint8_t>((first + 1U) % Size);
      --count;
    }
  };

  std::uint32_t events = 0;  // that the main loop has been told of and has not come to
  Blocks in;
  std::array<Ring<board_frames_out>, RS_PORTS> out;  // the first one is on its wire
};

struct Network::Unit {
  std::unique_ptr<rs_section_unit> state = std::make_unique<rs_section_unit>();
  rs_section_unit_config config{};
  std::uint16_t power = 0;
  std::uint16_t unfed = 0;  // bit p - 1: port p feeds no power whatever the unit wants
  bool stopped = false;
  std::uint32_t starts = 0;
  std::int64_t due_ns = never, scheduled_ns = never;

  // Its clock is virtual time, ahead by `ahead_ns`, and by `drift` of the time since `drifting_ns`.
  std::int64_t ahead_ns = 0, drifting_ns = 0;
  double drift = 0;

  std::int64_t clock_ns(std::int64_t time_ns) const {
    return time_ns + ahead_ns + static_cast<std::int64_t>(drift * static_cast<double>(time_ns - drifting_ns));
  }
  // The virtual time at which the clock shows at least `clock`.
  std::int64_t time_ns(std::int64_t clock) const {
    const std::int64_t since_ns = clock - ahead_ns - drifting_ns;
    if (drift == 0) return drifting_ns + since_ns;
    const std::int64_t time = drifting_ns + static_cast<std::int64_t>(static_cast<double>(since_ns) / (1 + drift)) + 1;
    return clock_ns(time) < clock ? time + 1 : time;  // products are rounded
  }
  void set_drift(std::int64_t now_ns, double share) {
    ahead_ns = clock_ns(now_ns) - now_ns;
    drifting_ns = now_ns;
    drift = share;
  }
};

// A datagram on its way between section units.
struct Network::InFlightDatagram {
  std::int64_t due_ns = never;  // never: the place is free
  std::uint32_t from = 0, to = 0, bytes = 0;
  std::array<std::uint8_t, RS_DATAGRAM_BYTES_MAX> datagram;
};

struct alignas(32) Network::Wire {
  const std::uint8_t* frame = nullptr;  // in the sender's state while it is sent
  std::int64_t end_ns = never;
  std::int32_t to = -1;  // the wire that leads back, whose sender is this one's receiver; -1: open end
  std::uint32_t frames = 0;
  std::uint8_t severed = 0;  // why frames into it do not arrive; 0: they do
  bool torn = false;         // something happened to it under way: the frame on it is lost
  bool troubled = false;     // see troubles_
  bool taped = false;        // what arrives here may be played again
};

struct Network::Trouble {
  double bit_error_rate = 0, lost_share = 0;
};

// A frame that was heard at a port, and when.
struct Network::Taped {
  std::int64_t time_ns = 0;
  std::array<std::uint8_t, RS_FRAME_BYTES> frame;
};

struct alignas(64) Network::Lane {
  // A datagram to the host that waits until all lanes have come as far.
  struct Outgoing {
    std::int64_t time_ns;
    std::uint32_t unit, first, bytes;
  };

  std::int64_t now_ns = 0;
  std::uint64_t log_hash = 0;
  std::uint64_t number = 0;
  EventQueue queue;
  NetworkCounts counts;
  std::uint64_t topology_revision = 0;
  std::uint64_t letters_posted = 0;
  std::vector<InFlightDatagram> in_flight;
  std::vector<std::uint32_t> cells, units;  // indices, rising
  std::vector<Outgoing> outgoing;
  std::vector<std::uint8_t> outgoing_bytes;

  void log(std::uint64_t word) {
    log_hash = (log_hash ^ word) * 0x9E3779B97F4A7C15U;
    log_hash ^= log_hash >> 29;
  }
};

inline Network::Lane& Network::lane_of_cell(std::size_t cell) {
  return lanes_[lane_of_cell_[cell]];
}
inline const Network::Lane& Network::lane_of_cell(std::size_t cell) const {
  return lanes_[lane_of_cell_[cell]];
}
inline Network::Lane& Network::lane_of_unit(std::size_t unit) {
  return lanes_[lane_of_unit_[unit]];
}
inline Network::Lane& Network::lane_of_wire(std::size_t wire) {
  return wire < cell_wires() ? lane_of_cell(wire / RS_PORTS)
                             : lane_of_unit((wire - cell_wires()) / RS_SECTION_UNIT_PORTS_MAX);
}

// Of the place where a fault strikes; the first, if that is everywhere.
inline Network::Lane& Network::lane_of(const Fault& fault) {
  if (fault.cell >= 0) return lane_of_cell(static_cast<std::size_t>(fault.cell));
  return fault.unit >= 0 ? lane_of_unit(static_cast<std::size_t>(fault.unit)) : lanes_.front();
}

// A fault, from its announcement on, and what of the network its file of faults/ may touch.
struct Network::RunningFault {
  Network& network;
  std::size_t number;  // among the acts
  Fault fault;
  int phase = 0;
  std::vector<std::size_t> wires;  // that it keeps, to end where it began
  std::vector<Taped> tape;         // frames it has heard, for it to play again
  std::size_t played = 0;          // of the tape

  std::int64_t now_ns() const { return network.lane_of(fault).now_ns; }
  std::uint64_t random_key(std::uint64_t of) const;

  // ---- The fault's targets ----
  std::size_t cell_index() const { return static_cast<std::size_t>(fault.cell); }
  Cell& cell() { return network.cells_[cell_index()]; }
  const Cell& cell_at(std::int32_t index) const { return network.cells_[static_cast<std::size_t>(index)]; }
  bool cell_is_on() const;
  bool cell_has_power() const;
  bool cell_is_zombie() const;
  void set_zombie(bool zombie);
  Unit& unit() { return network.units_[static_cast<std::size_t>(fault.unit)]; }

  // ---- Wires, by index ----
  std::size_t wire_count() const { return network.wires_.size(); }
  std::size_t cell_wires() const { return network.cell_wires(); }
  std::size_t wire_at(std::int32_t cell, std::int32_t port) const;
  Wire& wire(std::size_t index) { return network.wires_[index]; }
  std::vector<std::size_t> own_wires() const { return network.wires_of(fault); }
  void sever(const std::vector<std::size_t>& which, std::uint8_t why, bool out, bool in);
  void cut(bool out, bool in) { sever(own_wires(), severed_by_cut, out, in); }
  void part(std::size_t wire) { network.part(wire); }
  void join(std::size_t a, std::size_t b) { network.join(a, b); }
  void take_own_wires_both_ways();
  // Bits flip and frames vanish on the wires taken, more often by so much or, with a minus, less often again.
  void trouble(double bit_error_rate, double lost_share);

  // ---- Cells and units ----
  void topology_changed() { ++network.lanes_.front().topology_revision; }
  void supply() {
    for (Lane& lane : network.lanes_) network.supply(lane);
  }
  void step_cell(const rs_input& input) { network.step_cell(cell_index(), input); }
  void wake_cell(std::int64_t time_ns) { network.wake_cell(cell_index(), time_ns); }
  void report_idle_wires() { network.report_idle_wires(cell_index()); }
  void boot_unit() { network.boot_unit(static_cast<std::size_t>(fault.unit)); }
  void wake_unit() { network.wake_unit(static_cast<std::size_t>(fault.unit), now_ns()); }
  // Hands the fault's cell a frame that nothing on its wire has sent.
  void plant(const std::uint8_t* frame);

  // ---- Datagrams between units ----
  void trouble_ethernet(bool begins);
};

}  // namespace robotskin::world
