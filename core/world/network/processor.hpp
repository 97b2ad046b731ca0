// SPDX-License-Identifier: Apache-2.0
// What a cell's processor takes for one input: the cycles that the meter has counted on the emulated chip.
//
// An input takes as long as its kind and the frames that it starts let it: within one such class the meter's counts
// hardly differ. The table is written by `robotskin bench input_cycles --write`.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "robotskin/cell.h"
#include "robotskin/timing.h"

namespace robotskin::world {

enum class Processor : std::uint8_t { none, zero_wait_states, one_wait_state };  // none: it takes no time
inline constexpr std::array<std::string_view, 3> processor_names{"none", "zero_wait_states", "one_wait_state"};

inline constexpr std::int64_t processor_hz = 48'000'000;

// The board around it (firmware/chip/board.h): so many frames wait for the processor, in the last places none
// that goes to the host, and of each port so many are out or wait for the line.
inline constexpr std::size_t board_frames_in = 48, board_frames_kept = 8, board_frames_out = RS_FRAMES_OUT;

// Kinds of inputs. A frame counts as its type, but for a tick that begins a new wave, and any frame that is damaged;
// any input in which the cell computes its own torque of an epoch counts as `epoch`. The most frequent ones take a
// short way unless something is due in the cell: `sent` and `tick` count as `..._due` then, samples and events as a
// torque sum, which always goes the long way. An event that is sent again is looked for among those that are kept:
// `again`. A command that the cell passes on and need not look at counts as `command`, one that it carries out as
// `order`.
// clang-format off
#define RS_WORLD_INPUT_KINDS(X)                                                                                 \
  X(boot)                                                                                                       \
  X(sample) X(timer) X(epoch) X(sent) X(damaged) X(wave) X(clock) X(event) X(tick) X(status) X(grant) X(joints) \
      X(torque) X(topology) X(command) X(reply) X(join) X(sent_due) X(tick_due) X(order) X(again)
// clang-format on
#define RS_WORLD_INPUT_KIND(name) name,
enum class InputKind : std::uint8_t { RS_WORLD_INPUT_KINDS(RS_WORLD_INPUT_KIND) };
#undef RS_WORLD_INPUT_KIND
#define RS_WORLD_INPUT_NAME(name) std::string_view(#name),
inline constexpr std::array input_kind_names{RS_WORLD_INPUT_KINDS(RS_WORLD_INPUT_NAME)};
#undef RS_WORLD_INPUT_NAME

// By frames started, 0 to 4.
struct InputCycles {
  std::array<std::uint32_t, RS_PORTS + 1> zero_wait_states, one_wait_state;
};

// What tells the kind of an input, of the cell before it.
struct BeforeInput {
  std::uint32_t sequence, epoch, damaged;
  bool due;  // something is, so that all takes the long way

  BeforeInput(const rs_cell& cell, std::uint32_t now_us)
      : sequence(cell.route.wave.sequence),
        epoch(cell.torque.epoch),
        damaged(cell.counts.frames_damaged),
        due(cell.queues.calm_us - now_us - 1U >= RS_HEARTBEAT_US) {}
};

InputKind kind_of(const rs_input& input, const BeforeInput& before, const rs_cell& after);

std::int64_t processing_ns(Processor processor, InputKind kind, std::uint32_t frames_started);

}  // namespace robotskin::world
