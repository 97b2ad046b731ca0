// SPDX-License-Identifier: Apache-2.0
// Watches a network while it runs: told after every event, changes nothing.
//
// Without observers a network pays one comparison an event for them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "robotskin/cell.h"
#include "robotskin/section_unit.h"
#include "world/network/fault.hpp"

namespace robotskin::world {

class Network;

// One end of a wire; ports from 1.
struct WireEnd {
  enum class At : std::uint8_t { nothing, cell, unit };

  At at = At::nothing;
  std::uint8_t port = 0;
  std::uint32_t index = 0;  // of cell or unit

  bool operator==(const WireEnd&) const = default;
};

// Damaged ones are delivered too; overrun: it came to a cell that was too busy to take it.
enum class FrameFate : std::uint8_t { delivered, damaged, lost, overrun };

class Observer {
 public:
  virtual ~Observer() = default;

  // A cell or section unit has taken an input, and its frames are on their wires.
  virtual void cell_stepped(const Network&, std::size_t /*cell*/, const rs_input&, const rs_output&) {}
  virtual void unit_stepped(const Network&, std::size_t /*unit*/, const rs_unit_input&, const rs_unit_output&) {}
  // A frame begins on a wire, whether or not anything is at its other end.
  virtual void frame_sent(const Network&, WireEnd /*from*/, const std::uint8_t* /*frame*/) {}
  // It has arrived, or has not; the receiver steps next.
  virtual void frame_ended(const Network&, WireEnd /*from*/, WireEnd /*to*/, const std::uint8_t* /*frame*/, FrameFate) {
  }
  // A fault is about to hand a cell a frame that no sender on its wire has sent: forged, or played again.
  virtual void frame_planted(const Network&, WireEnd /*to*/, const std::uint8_t* /*frame*/, const Fault&) {}
  virtual void datagram_to_host(const Network&, std::size_t /*unit*/, std::span<const std::uint8_t>) {}
  virtual void datagram_from_host(const Network&, std::size_t /*unit*/, std::span<const std::uint8_t>) {}
  // Over Ethernet between two section units of a group; `arrived` false: lost on the way.
  virtual void datagram_to_peer(const Network&, std::size_t /*from*/, std::size_t /*to*/, std::span<const std::uint8_t>,
                                bool /*arrived*/) {}
  // A fault has struck (phase 0), or gone on or ended (phase 1 and more).
  virtual void fault_applied(const Network&, const Fault&, int /*phase*/) {}
};

}  // namespace robotskin::world
