// SPDX-License-Identifier: Apache-2.0
// What ticks were really issued by roots, and which beacons really arrived at each cell's ports.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "campaign/ground_truth.hpp"
#include "robotskin/wire.h"

namespace robotskin::campaign {

// What a root fixes in a tick.
struct IssuedTick {
  std::uint32_t tag = 0;
  std::uint16_t sequence = 0, era = 0;
  std::uint8_t root = 0, rate_divisor = 0, depth_cap = 0, gain_threshold = 0;
  bool valid = false;
};

struct ArrivedBeacon {
  std::int64_t time_ns = -1;
  std::uint16_t sequence = 0;
  std::uint8_t hops = RS_HOPS_POISON, root = 0;
  bool parent = false;   // the receiver is the sender's parent
  bool planted = false;  // played again by a fault
};

class BeaconLog {
 public:
  static constexpr std::size_t ticks_kept = 256;  // a root
  static constexpr std::size_t beacons_kept = 4;  // a port

  explicit BeaconLog(const GroundTruth& ground) : ground_(ground), arrived_(ground.wire_count()) {}

  void issued(const rs_tick& tick);                                             // by a section unit
  void arrived(std::size_t at_wire, const rs_tick& tick, std::int64_t now_ns);  // whole, at a cell's port
  void planted(std::size_t at_wire, const rs_tick& tick, std::int64_t now_ns);  // the same, not from the neighbour
  void forget(std::size_t at_wire) { arrived_[at_wire] = {}; }

  // The tick of this number and root, if it was issued lately; null: never was.
  const IssuedTick* find(const rs_wave& wave) const;
  // The last beacon of this content at the port; null: none of the last few.
  const ArrivedBeacon* find(std::size_t at_wire, std::uint16_t sequence, std::uint8_t hops) const;
  const ArrivedBeacon& newest(std::size_t at_wire) const { return arrived_[at_wire].beacon[arrived_[at_wire].last]; }
  // The neighbour says to be the receiver's child, in its own last beacon and in what was played again since.
  bool child(std::size_t at_wire) const { return arrived_[at_wire].own_child && newest(at_wire).parent; }
  std::uint32_t newest_time() const { return newest_time_; }  // tick time of the root that is furthest ahead
  bool any() const { return any_; }

 private:
  void keep(std::size_t at_wire, const rs_tick& tick, std::int64_t now_ns, bool planted);

  struct Port {
    std::array<ArrivedBeacon, beacons_kept> beacon;
    std::uint8_t last = 0;
    bool own_child = false;  // of the last that was not planted
  };

  const GroundTruth& ground_;
  std::vector<Port> arrived_;
  std::array<std::vector<IssuedTick>, 256> issued_;  // by root
  std::uint32_t newest_time_ = 0;
  bool any_ = false;
};

}  // namespace robotskin::campaign
