// SPDX-License-Identifier: Apache-2.0
// The states a controlled robot can be in, and what leads from one to another: the whole of it, as data.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace robotskin::robot {

// off: nothing known of the joints. ready: holds still and may start. running: obeys the controller. degraded: obeys it
// slowly, since part of the skin is missing. stopped: brought to rest and held, until it is no longer wanted to run.
// A robot that stands balances in all states but off.
enum class SafetyState : std::uint8_t { off, ready, running, degraded, stopped };
inline constexpr std::size_t safety_state_count = 5;

// What is checked every cycle, one bit each.
enum Condition : std::uint16_t {
  joints_fresh = 1 << 0,   // the joint state is finite and young enough
  joints_inside = 1 << 1,  // no joint is beyond its position limits or faster than its velocity limit
  skin_fresh = 1 << 2,     // the skin's snapshot is young enough and enough of its cells are alive to go on
  skin_whole = 1 << 3,     // enough of its cells are alive for full speed
  command_finite = 1 << 4,
  on_time = 1 << 5,         // the last cycle did not overrun by more than the limit
  wanted = 1 << 6,          // the robot is wanted to run
  at_rest = 1 << 7,         // no joint moves faster than the speed of rest
  contact_within = 1 << 8,  // no contact is beyond the limits of a body region, as far as any are given
  balanced = 1 << 9,        // a robot that stands can still come to rest above its feet; always so of a mounted one
};

enum class Reason : std::uint8_t {
  none,
  joints_stale,        // no fresh joint state
  joints_beyond,       // a joint beyond its position or velocity limit
  skin_lost,           // no fresh skin, in the sense of liveness: silence alone is not loss
  skin_partly_lost,    // cells missing: slow, not stopped
  command_not_finite,  // the controller had no finite answer
  overrun,             // a cycle came too late
  asked,               // the robot is no longer wanted to run
  body_limit,          // a contact beyond the limit of a body region, or one that cannot be known
  unbalanced,          // the robot is about to fall
};

struct Transition {
  SafetyState from;
  std::uint16_t all_of;   // conditions that must hold
  std::uint16_t none_of;  // conditions that must not hold
  SafetyState to;
  Reason reason;
};

// The first row that fits is taken, one a cycle; none: the state stays.
inline constexpr std::array safety_table = {
    Transition{SafetyState::off, joints_fresh, 0, SafetyState::ready, Reason::none},

    Transition{SafetyState::ready, 0, joints_fresh, SafetyState::off, Reason::joints_stale},
    Transition{SafetyState::ready,
               wanted | joints_inside | skin_fresh | command_finite | on_time | contact_within | balanced, 0,
               SafetyState::running, Reason::none},

    Transition{SafetyState::running, 0, joints_fresh, SafetyState::stopped, Reason::joints_stale},
    Transition{SafetyState::running, 0, joints_inside, SafetyState::stopped, Reason::joints_beyond},
    Transition{SafetyState::running, 0, balanced, SafetyState::stopped, Reason::unbalanced},
    Transition{SafetyState::running, 0, contact_within, SafetyState::stopped, Reason::body_limit},
    Transition{SafetyState::running, 0, skin_fresh, SafetyState::stopped, Reason::skin_lost},
    Transition{SafetyState::running, 0, command_finite, SafetyState::stopped, Reason::command_not_finite},
    Transition{SafetyState::running, 0, on_time, SafetyState::stopped, Reason::overrun},
    Transition{SafetyState::running, 0, wanted, SafetyState::stopped, Reason::asked},
    Transition{SafetyState::running, 0, skin_whole, SafetyState::degraded, Reason::skin_partly_lost},

    Transition{SafetyState::degraded, 0, joints_fresh, SafetyState::stopped, Reason::joints_stale},
    Transition{SafetyState::degraded, 0, joints_inside, SafetyState::stopped, Reason::joints_beyond},
    Transition{SafetyState::degraded, 0, balanced, SafetyState::stopped, Reason::unbalanced},
    Transition{SafetyState::degraded, 0, contact_within, SafetyState::stopped, Reason::body_limit},
    Transition{SafetyState::degraded, 0, skin_fresh, SafetyState::stopped, Reason::skin_lost},
    Transition{SafetyState::degraded, 0, command_finite, SafetyState::stopped, Reason::command_not_finite},
    Transition{SafetyState::degraded, 0, on_time, SafetyState::stopped, Reason::overrun},
    Transition{SafetyState::degraded, 0, wanted, SafetyState::stopped, Reason::asked},
    Transition{SafetyState::degraded, skin_whole, 0, SafetyState::running, Reason::none},

    Transition{SafetyState::stopped, joints_fresh | at_rest, wanted, SafetyState::ready, Reason::none},
};

// One evaluation. Returns the row taken, or nullptr if the state stays.
constexpr const Transition* next_transition(SafetyState state, std::uint16_t conditions) noexcept {
  for (const Transition& row : safety_table)
    if (row.from == state && (conditions & row.all_of) == row.all_of && (conditions & row.none_of) == 0) return &row;
  return nullptr;
}

constexpr const char* name(SafetyState state) noexcept {
  constexpr std::array<const char*, safety_state_count> names = {"off", "ready", "running", "degraded", "stopped"};
  return names[static_cast<std::size_t>(state)];
}

constexpr const char* name(Reason reason) noexcept {
  constexpr std::array<const char*, 10> names = {
      "none",
      "no fresh joint state",
      "a joint is beyond its position or velocity limit",
      "no fresh skin",
      "part of the skin is missing",
      "the controller's command is not finite",
      "a cycle came too late",
      "stopped on request",
      "a contact is beyond the limit of a body region",
      "the robot is about to fall",
  };
  return names[static_cast<std::size_t>(reason)];
}

}  // namespace robotskin::robot
