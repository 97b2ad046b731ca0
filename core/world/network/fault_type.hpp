// SPDX-License-Identifier: Apache-2.0
// What a kind of fault is: its text, and how it is checked, drawn, begun, ended, and told to those that watch. Each
// file of faults/ defines one, under the file's name; CMake makes the list.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "world/network/fault.hpp"
#include "world/network/fault_draw.hpp"
#include "world/network/fault_witness.hpp"
#include "world/network/network.hpp"

namespace robotskin::world {

// How a kind goes on after it has begun.
enum class FaultCourse : std::uint8_t {
  lasting,      // it ends after `lasts_ns`, unless that is 0
  momentary,    // it does not end
  alternating,  // it begins and ends `count` times, half of `by_ns` each
  repeated      // it begins `count` times, every `by_ns`
};

enum class FaultTo : std::uint8_t { nothing, cell, cell_or_none, unit };  // what the key `to` names

// What a checker of the network may conclude from the kind alone.
struct FaultTruth {
  enum class Loses : std::uint8_t { nothing, cell, wire };
  enum class Plants : std::uint8_t { nothing, forged, replayed };

  Loses loses = Loses::nothing;     // all that it does is to take away its cell, or what its wire carries
  Plants plants = Plants::nothing;  // frames that come in though nothing on the wire has sent them
  bool everywhere = false;          // the repair may have to travel further than from what it cut off
  bool overwrites_memory = false;
};

// A datagram between two section units.
struct FaultyPassage {
  std::size_t from, to;
  std::int64_t delay_ns;
  double chance;  // drawn, 0 to 1
  bool lost = false;
};

struct FaultType {
  std::uint8_t number;  // of the kind, from 0 without gaps; draws go by it
  std::string_view name;
  // Keys with the values they have if left out, or `!` if they must be given (fault_text.cpp has all keys).
  std::string_view keys;
  std::string_view text;  // what happens

  // ---- Targets ----
  bool either = false;  // one of `cell` and `unit` names the place
  FaultTo to = FaultTo::nothing;
  bool may_go_back = false;  // `by` may be negative

  // ---- Drawing ----
  void (*draw)(FaultDraw&, Fault&) = nullptr;                                    // none: it is never drawn
  bool (*can_be_drawn)(const Wiring&, std::span<const Fault> so_far) = nullptr;  // none: always

  // ---- In a run ----
  FaultCourse course = FaultCourse::lasting;
  void (*at_start)(const Fault&, NetworkOptions&) = nullptr;  // before the network is built; it cannot come later
  void (*await)(Network::RunningFault&) = nullptr;            // when it is announced, at the start as a rule
  void (*begin)(Network::RunningFault&, int phase) = nullptr;
  void (*end)(Network::RunningFault&) = nullptr;
  void (*heard)(Network::RunningFault&, std::size_t wire, const std::uint8_t* frame) = nullptr;  // on a taped wire
  void (*passage)(const Fault&, FaultyPassage&) = nullptr;                                       // while it is in force

  // ---- What is true then ----
  FaultTruth truth{};
  void (*tell)(const Fault&, bool begins, FaultWitness&) = nullptr;  // none: nothing that a way depends on
};

// One a file.
namespace faults {
#define ROBOTSKIN_FAULT(name) extern const FaultType name;
#include "world/network/fault_list.inc"
#undef ROBOTSKIN_FAULT
}  // namespace faults

// All kinds, by number.
std::span<const FaultType* const> fault_types();
const FaultType& type_of(const Fault& fault);

// From the beginning to the end of the last time; 0: for good, or no time at all.
std::int64_t duration_ns(const Fault& fault);

}  // namespace robotskin::world
