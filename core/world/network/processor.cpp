// SPDX-License-Identifier: Apache-2.0
#include "world/network/processor.hpp"

#include "robotskin/wire.h"
#include "world/network/input_cycles.hpp"

namespace robotskin::world {
namespace {

InputKind kind_of_frame(const std::uint8_t* frame) {
  switch (rs_frame_type_of(frame)) {
#define RS_KIND_OF_TYPE(name, number, text) \
  case RS_TYPE_##name:                      \
    return InputKind::name;
    RS_FRAME_TYPES(RS_KIND_OF_TYPE)
#undef RS_KIND_OF_TYPE
    default:
      return InputKind::damaged;  // of no known type: it is looked at no further either
  }
}

}  // namespace

InputKind kind_of(const rs_input& input, const BeforeInput& before, const rs_cell& after) {
  if (input.kind == RS_INPUT_BOOT) return InputKind::boot;
  if (after.torque.epoch != before.epoch && after.cell_torque.known != 0) return InputKind::epoch;
  switch (input.kind) {
    case RS_INPUT_SAMPLE:
      return InputKind::sample;
    case RS_INPUT_SENT:
      return InputKind::sent;
    case RS_INPUT_FRAME: {
      if (after.counts.frames_damaged != before.damaged) return InputKind::damaged;
      const InputKind kind = kind_of_frame(input.frame);
      return kind == InputKind::tick && after.route.wave.sequence != before.sequence ? InputKind::wave : kind;
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
