// SPDX-License-Identifier: Apache-2.0
// True frames that are played again.
#include <algorithm>

#include "robotskin/crc.h"
#include "world/network/fault_type.hpp"
#include "world/network/faults/attack.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

bool is_tagged(rs_frame_type type) {
  return type == RS_TYPE_tick || type == RS_TYPE_grant || type == RS_TYPE_command || type == RS_TYPE_joints;
}

void draw(FaultDraw& draw, Fault& fault) {
  draw_attack(draw, fault);
  fault.lasts_ns = draw.time_between(2 * FaultDraw::ms, 200 * FaultDraw::ms);
}

void await(Network::RunningFault& act) {
  act.wire(act.own_wires().front()).taped = true;
}

void heard(Network::RunningFault& act, std::size_t wire, const std::uint8_t* frame) {
  if (!is_tagged(rs_frame_type_of(frame)) || !rs_frame_intact(frame)) return;
  if (act.own_wires().front() != wire || act.now_ns() < act.fault.time_ns - act.fault.lasts_ns) return;
  auto& taped = act.tape.emplace_back();
  taped.time_ns = act.now_ns();
  std::copy_n(frame, RS_FRAME_BYTES, taped.frame.begin());
}

void begin(Network::RunningFault& act, int) {
  if (!act.cell_is_on()) return;
  if (act.played >= act.tape.size() || act.tape[act.played].time_ns > act.now_ns() - act.fault.lasts_ns) return;
  const auto frame = act.tape[act.played++].frame;
  act.plant(frame.data());
}

}  // namespace

constinit const FaultType replay{
    .number = 15,
    .name = "replay",
    .keys = "cell! port! ago=50ms times=10 period=1ms",
    .text = "tagged frames that came in at the port so long ago come in again",
    .draw = draw,
    .course = FaultCourse::repeated,
    .await = await,
    .begin = begin,
    .heard = heard,
    .truth = {.plants = FaultTruth::Plants::replayed},
};

}  // namespace robotskin::world::faults
