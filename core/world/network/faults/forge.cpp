// SPDX-License-Identifier: Apache-2.0
// Frames that no root has signed.
#include <array>

#include "robotskin/crc.h"
#include "robotskin/operations.h"
#include "robotskin/timing.h"
#include "world/network/fault_type.hpp"
#include "world/network/faults/attack.hpp"
#include "world/network/parts.hpp"

namespace robotskin::world::faults {
namespace {

// The neighbour's last beacon with another content of what the root signs, and of what goes with it.
void forge_tick(const rs_cell& cell, unsigned port, RandomStream& draw, std::uint8_t* frame) {
  const rs_neighbour& neighbour = cell.route.neighbour[port];
  const bool of_parent = cell.route.parent_port == port + 1U;
  rs_tick tick{};
  tick.type = RS_TYPE_tick;
  tick.sequence = (neighbour.wave.sequence + 1U + draw.below(RS_SEQUENCE_WINDOW)) & 0xFFFFU;
  tick.hops = static_cast<std::uint32_t>(draw.below(4));
  tick.root = draw.below(2) == 0 ? neighbour.wave.root : 1 + static_cast<std::uint32_t>(draw.below(255));
  tick.sender = neighbour.id;
  tick.sender_port = (neighbour.port - 1U) & 3U;
  tick.nonce = neighbour.nonce;
  tick.parent = neighbour.child == 0;
  tick.heard = 1;
  tick.draining = neighbour.draining == 0;
  tick.forming = static_cast<std::uint32_t>(draw.below(2));
  tick.depth_cap = RS_TTL_START;
  tick.rate_divisor = 1 + static_cast<std::uint32_t>(draw.below(15));
  tick.gain_threshold = 1;
  // Of a child: what is expected next; of the parent: a number that nothing was announced under.
  tick.ack = of_parent ? (cell.arq_sender.number + 64U) & RS_NUMBER_MASK : neighbour.arq_receiver.next;
  tick.era = neighbour.wave.era;
  tick.tag = static_cast<std::uint32_t>(draw.bits());
  rs_tick_pack(frame, &tick);
}

void forge_grant(const rs_cell& cell, RandomStream& draw, std::uint8_t* frame) {
  rs_grant grant{};
  grant.type = RS_TYPE_grant;
  grant.sequence = cell.route.wave.sequence;
  grant.root = cell.route.wave.root;
  grant.round = static_cast<std::uint32_t>(draw.below(8));
  grant.cell = cell.id;
  for (const rs_neighbour& neighbour : cell.route.neighbour)
    if (neighbour.up && neighbour.wave.root != cell.route.wave.root) grant.target_root = neighbour.wave.root;
  grant.demand_1_root = grant.target_root;
  grant.demand_1_size = 1 + static_cast<std::uint32_t>(draw.below(100));
  grant.tag = static_cast<std::uint32_t>(draw.bits());
  rs_grant_pack(frame, &grant);
}

void forge_command(const rs_cell& cell, RandomStream& draw, std::uint8_t* frame) {
  constexpr std::array<std::pair<rs_operation, std::uint32_t>, 5> orders{{{RS_OPERATION_led, 0xFF00FF},
                                                                          {RS_OPERATION_clock_rate, 0},
                                                                          {RS_OPERATION_mode, RS_MODE_EVENT},
                                                                          {RS_OPERATION_forget, 0},
                                                                          {RS_OPERATION_rejoin, 0}}};
  const auto& [operation, value] = orders[draw.below(orders.size())];
  rs_command command{};
  command.type = RS_TYPE_command;
  command.target = RS_ID_ALL;
  command.operation = operation;
  command.counter = (cell.commanding.counter + 1U + draw.below(100)) & 0xFFFFU;
  command.index = operation == RS_OPERATION_rejoin ? cell.id : 0U;
  command.value_low = operation == RS_OPERATION_rejoin ? cell.uid : value;
  command.tag = static_cast<std::uint32_t>(draw.bits());
  rs_command_pack(frame, &command);
}

void forge_joints(const rs_cell& cell, RandomStream& draw, std::uint8_t* frame) {
  rs_joints joints{};
  joints.type = RS_TYPE_joints;
  joints.epoch = cell.torque.epoch & RS_EPOCH_MASK;
  joints.limb = cell.torque.own.limb & 0xFU;
  joints.joint_1 = static_cast<std::int16_t>(draw.bits());
  joints.tag = static_cast<std::uint32_t>(draw.bits());
  rs_joints_pack(frame, &joints);
}

void forge_frame(const rs_cell& cell, const Fault& fault, RandomStream& draw, std::uint8_t* frame) {
  switch (fault.what) {
    case FaultFrame::tick:
      forge_tick(cell, static_cast<unsigned>(fault.port - 1), draw, frame);
      break;
    case FaultFrame::grant:
      forge_grant(cell, draw, frame);
      break;
    case FaultFrame::command:
      forge_command(cell, draw, frame);
      break;
    case FaultFrame::joints:
      forge_joints(cell, draw, frame);
      break;
  }
  rs_frame_seal(frame);
}

void draw(FaultDraw& draw, Fault& fault) {
  draw_attack(draw, fault);
  fault.what = static_cast<FaultFrame>(draw.below(4));
}

void begin(Network::RunningFault& act, int phase) {
  if (!act.cell_is_on()) return;
  std::array<std::uint8_t, RS_FRAME_BYTES> frame;
  RandomStream draw(act.random_key(static_cast<std::uint64_t>(act.number) << 32 | static_cast<unsigned>(phase)));
  forge_frame(act.cell().state, act.fault, draw, frame.data());
  act.plant(frame.data());
}

}  // namespace

constinit const FaultType forge{
    .number = 14,
    .name = "forge",
    .keys = "cell! port! what=tick times=10 period=1ms",
    .text = "frames under a wrong tag come in at the port: what=tick, grant, command or joints",
    .draw = draw,
    .course = FaultCourse::repeated,
    .begin = begin,
    .truth = {.plants = FaultTruth::Plants::forged},
};

}  // namespace robotskin::world::faults
