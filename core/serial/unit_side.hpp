// SPDX-License-Identifier: Apache-2.0
// A section unit's firmware between lines and datagrams, without either: time and bytes are given to it.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>

#include "driver/keyed_hash.hpp"
#include "robotskin/section_unit.h"

namespace robotskin::serial {

inline constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();
// A frame at 4 Mb/s. Neither USB nor a pseudo-terminal tells when it is out.
inline constexpr std::int64_t frame_ns = 1'000'000'000LL * RS_FRAME_BYTES * RS_LINK_BITS_PER_BYTE / RS_LINK_BAUD;

using CellKey = std::array<std::uint8_t, RS_CELL_KEY_BYTES>;
using FrameBytes = std::span<const std::uint8_t, RS_FRAME_BYTES>;

struct UnitOptions {
  std::uint16_t group = 1;
  std::uint8_t unit = 0;   // within the group
  std::uint8_t ports = 1;  // 1 to 15
  std::uint8_t units = 1;  // in the group: each gives other ids
  std::uint32_t batch_us = 1000;
  std::uint32_t session = 1;  // drawn at each start, never 0
  bool unasked = false;       // sends without a keep-alive
  std::optional<driver::Key> key;
  std::optional<CellKey> cell_key;
};

class UnitSide {
 public:
  // Where frames and datagrams go.
  class Outward {
   public:
    virtual ~Outward() = default;
    virtual void frame(unsigned port, FrameBytes frame, std::int64_t now_ns) = 0;  // port from 1
    virtual void datagram(std::span<const std::uint8_t> datagram, bool to_peers) = 0;
  };

  UnitSide(const UnitOptions& options, Outward& outward, std::int64_t now_ns);

  void frame(unsigned port, FrameBytes frame, std::int64_t now_ns);
  // Whether the firmware took it.
  bool datagram(std::span<const std::uint8_t> datagram, std::int64_t now_ns);
  // Does what is due; when to come again.
  std::int64_t advance(std::int64_t now_ns);

  const rs_section_unit& state() const { return *state_; }

 private:
  void step(const rs_unit_input& input, std::int64_t now_ns);

  Outward& outward_;
  std::optional<driver::KeyedHash> hash_;
  std::optional<CellKey> cell_key_;
  std::unique_ptr<rs_section_unit> state_ = std::make_unique<rs_section_unit>();
  std::array<std::int64_t, RS_SECTION_UNIT_PORTS_MAX> out_ns_;  // when the frame on a port is out
  std::int64_t timer_ns_ = never;
};

}  // namespace robotskin::serial
