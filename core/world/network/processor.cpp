// SPDX-License-Identifier: Apache-2.0
#include "world/network/processor.hpp"

#include <algorithm>
#include <string_view>

#include "robotskin/crc.h"
#include "robotskin/operations.h"
#include "robotskin/wire.h"
#include "world/network/input_cycles.hpp"

namespace robotskin::world {
namespace {

// Further channels go the way of clock samples; at a key frame a cell that runs looks no further.
constexpr InputKind kind_named(std::string_view type) {
  const std::string_view name = type == "further" ? "clock" : type == "key" ? "damaged" : type;
  return static_cast<InputKind>(std::ranges::find(input_kind_names, name) - input_kind_names.begin());
}

InputKind kind_of_frame(const std::uint8_t* frame) {
  switch (rs_frame_type_of(frame)) {
#define RS_KIND_OF_TYPE(name, number, text)                                  \
  case RS_TYPE_##name: {                                                     \
    constexpr InputKind kind = kind_named(#name);                            \
    static_assert(static_cast<std::size_t>(kind) < input_kind_names.size()); \
    return kind;                                                             \
  }
    RS_FRAME_TYPES(RS_KIND_OF_TYPE)
#undef RS_KIND_OF_TYPE
    default:
      return InputKind::damaged;  // of no known type: it is looked at no further either
  }
}

}  // namespace

namespace {

// A command to a cell or to all, as told by the cell's own rule.
bool carries_out(const rs_cell& cell, const std::uint8_t* frame) {
  rs_command command;
  rs_command_unpack(&command, frame);
  if (command.operation == RS_OPERATION_assign || command.operation == RS_OPERATION_rejoin)
    return command.value_low == cell.uid;
  return command.target == RS_ID_ALL || command.target == cell.id;
}

}  // namespace

InputKind kind_of(const rs_input& input, const BeforeInput& before, const rs_cell& after) {
  if (input.kind == RS_INPUT_BOOT) return InputKind::boot;
  if (after.torque.epoch != before.epoch && after.cell_torque.known != 0) return InputKind::epoch;
  switch (input.kind) {
    case RS_INPUT_SAMPLE:
      return InputKind::sample;
    case RS_INPUT_SENT:
      return before.due ? InputKind::sent_due : InputKind::sent;
    case RS_INPUT_FRAME: {
      if (after.counts.frames_damaged != before.damaged) return InputKind::damaged;
      const InputKind kind = kind_of_frame(input.frame);
      if ((kind == InputKind::clock || kind == InputKind::event) && before.due) return InputKind::torque;
      if (kind == InputKind::event && rs_frame_is_retransmitted(input.frame)) return InputKind::again;
      if (kind == InputKind::command && carries_out(after, input.frame)) return InputKind::order;
      if (kind != InputKind::tick) return kind;
      if (after.route.wave.sequence != before.sequence) return InputKind::wave;
      return before.due ? InputKind::tick_due : kind;
    }
    default:
      return InputKind::timer;
  }
}

std::int64_t processing_ns(Processor processor, InputKind kind, std::uint32_t frames_started) {
  if (processor == Processor::none) return 0;
  const InputCycles& cycles = input_cycles[static_cast<std::size_t>(kind)];
  const auto& taken = processor == Processor::zero_wait_states ? cycles.zero_wait_states : cycles.one_wait_state;
  return std::int64_t{taken[frames_started]} * 1'000'000'000 / processor_hz;
}

}  // namespace robotskin::world
