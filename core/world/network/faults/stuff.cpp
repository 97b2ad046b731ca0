// SPDX-License-Identifier: Apache-2.0
// Queues that are filled at once.
#include "robotskin/crc.h"
#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

constexpr std::int64_t queues_empty_ns = 60 * FaultDraw::ms;

void draw(FaultDraw& draw, Fault& fault) {
  fault.cell = draw.cell();
  fault.port = draw.port(fault.cell);
  fault.count = 20 + static_cast<std::int32_t>(draw.below(180));
}

void begin(Network::RunningFault& act, int) {
  if (!act.cell_is_on()) return;
  rs_clock sample{};
  sample.type = RS_TYPE_clock;
  sample.source = RS_ID_NONE;
  sample.ttl = RS_TTL_START;
  std::uint8_t frame[RS_FRAME_BYTES];
  // No line brings so many at once, so they take none of the processor's time: a cell without a way takes 50 us for
  // each, and would be deaf for longer than its links hold.
  const std::int64_t free_ns = act.cell().free_ns;
  for (std::int32_t k = 0; k < act.fault.count; ++k) {
    sample.sequence = static_cast<std::uint32_t>(k) & 0x3U;
    rs_clock_pack(frame, &sample);
    rs_frame_seal(frame);
    rs_input input{};
    input.kind = RS_INPUT_FRAME;
    input.port = static_cast<std::uint8_t>(act.fault.port);
    input.frame = frame;
    act.step_cell(input);
    act.cell().free_ns = free_ns;
  }
}

void tell(const Fault&, bool, FaultWitness& witness) {
  witness.samples_disturbed(queues_empty_ns);
}

}  // namespace

constinit const FaultType stuff{
    .number = 11,
    .name = "stuff",
    .keys = "cell! port=1 frames=100",
    .text = "so many samples of no cell arrive at once",
    .draw = draw,
    .course = FaultCourse::momentary,
    .begin = begin,
    .tell = tell,
};

}  // namespace robotskin::world::faults
