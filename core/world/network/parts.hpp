// What the network is made of; known to its own sources only.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>

#include "world/network/network.hpp"

namespace robotskin::world {

inline constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();
inline constexpr std::int64_t ethernet_ns = 200'000;  // between two section units
inline constexpr double frame_us = 1e6 * double{RS_FRAME_BYTES * RS_LINK_BITS_PER_BYTE} / double{RS_LINK_BAUD};

// Streams of random numbers, each of its own for a cell, wire or unit.
enum NetworkPurpose : std::uint64_t { purpose_clock = 11, purpose_wire = 12, purpose_boot = 13, purpose_session = 14 };

struct Network::Cell {
  enum class Power : std::uint8_t { off, starting, on, dead };

  Power power = Power::off;
  bool sampling = false;
  std::uint32_t timer_us = 0, sample_us = 0;
  std::uint32_t clock_start_us = 0;
  double us_per_ns = 1e-3, ns_per_us = 1e3;
  std::int64_t due_ns = never, scheduled_ns = never;
  std::uint64_t boot_key = 0, boots = 0;
  std::uint32_t queue_peak = 0;
  rs_sample sample{};
  rs_cell state{};
  std::uint8_t flash[RS_FLASH_BYTES] = {};

  std::uint32_t clock_us(std::int64_t time_ns) const {
    return clock_start_us +
           static_cast<std::uint32_t>(static_cast<std::uint64_t>(static_cast<double>(time_ns) * us_per_ns));
  }
};

struct Network::Unit {
  std::unique_ptr<rs_section_unit> state = std::make_unique<rs_section_unit>();
  rs_section_unit_config config{};
  std::uint16_t power = 0;
  std::int64_t due_ns = never, scheduled_ns = never;
};

// A datagram on its way between section units.
struct Network::Letter {
  std::int64_t due_ns = never;  // never: the place is free
  std::uint32_t to = 0, bytes = 0;
  std::array<std::uint8_t, RS_DATAGRAM_BYTES_MAX> datagram;
};

struct Network::Wire {
  const std::uint8_t* frame = nullptr;  // in the sender's state while it is sent
  std::int64_t end_ns = never;
  std::int32_t to = -1;  // the wire that leads back, whose sender is this one's receiver; -1: open end
  bool cut = false;
  double frame_ns = 1e3 * frame_us;
  std::uint64_t key = 0, frames = 0;
};

}  // namespace robotskin::world
