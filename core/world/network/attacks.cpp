// Frames that nobody on the wire has sent: forged ones under a wrong tag, and true ones played again.
#include <algorithm>

#include "robotskin/crc.h"
#include "robotskin/operations.h"
#include "robotskin/timing.h"
#include "world/network/parts.hpp"
#include "world/random.hpp"

namespace robotskin::world {
namespace {

bool is_tagged(rs_frame_type type) {
  return type == RS_TYPE_tick || type == RS_TYPE_grant || type == RS_TYPE_command || type == RS_TYPE_joints;
}

// The neighbour's last advert with another content of what the root signs, and of what goes with it.
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
  tick.leaving = neighbour.leaving == 0;
  tick.forming = static_cast<std::uint32_t>(draw.below(2));
  tick.depth_cap = RS_TTL_START;
  tick.rate_divisor = 1 + static_cast<std::uint32_t>(draw.below(15));
  tick.gain_threshold = 1;
  // Of a child: what is expected next; of the parent: a number that nothing was announced under.
  tick.echo = of_parent ? (cell.retention.number + 64U) & RS_NUMBER_MASK : neighbour.hearing.next;
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
  grant.want_1_root = grant.target_root;
  grant.want_1_size = 1 + static_cast<std::uint32_t>(draw.below(100));
  grant.whole = static_cast<std::uint32_t>(draw.below(2));
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
  joints.tag = static_cast<std::uint32_t>(draw.bits()) & 0xFFFFFFU;
  rs_joints_pack(frame, &joints);
}

void forge(const rs_cell& cell, const Fault& fault, RandomStream& draw, std::uint8_t* frame) {
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

}  // namespace

void Network::tape(std::size_t wire, const std::uint8_t* frame) {
  if (!is_tagged(rs_frame_type_of(frame)) || !rs_frame_intact(frame)) return;
  for (Act& act : acts_) {
    if (act.fault.kind != FaultKind::replay || wires_of(act.fault).front() != wire) continue;
    if (now_ns_ < act.fault.time_ns - act.fault.lasts_ns) continue;
    Taped& taped = act.tape.emplace_back();
    taped.time_ns = now_ns_;
    std::copy_n(frame, RS_FRAME_BYTES, taped.frame.begin());
  }
}

// One frame. The cell first does what is due, so that what changes then comes from the frame.
void Network::attack(Act& act, int phase) {
  const Fault& fault = act.fault;
  const auto index = static_cast<std::size_t>(fault.cell);
  if (cells_[index].power != Cell::Power::on) return;
  std::array<std::uint8_t, RS_FRAME_BYTES> frame;
  if (fault.kind == FaultKind::forge) {
    const auto number = static_cast<std::uint64_t>(&act - acts_.data()) << 32 | static_cast<unsigned>(phase);
    RandomStream draw(stream_key(options_.seed, purpose_act, number));
    forge(cells_[index].state, fault, draw, frame.data());
  } else {
    if (act.played >= act.tape.size() || act.tape[act.played].time_ns > now_ns_ - fault.lasts_ns) return;
    frame = act.tape[act.played++].frame;
  }
  rs_input input{};
  input.kind = RS_INPUT_TIMER;
  step_cell(index, input);
  if (cells_[index].power != Cell::Power::on) return;
  const WireEnd to{WireEnd::At::cell, static_cast<std::uint8_t>(fault.port), static_cast<std::uint32_t>(index)};
  tell([&](Observer& observer) { observer.frame_planted(*this, to, frame.data(), fault); });
  input.kind = RS_INPUT_FRAME;
  input.port = to.port;
  input.frame = frame.data();
  step_cell(index, input);
}

}  // namespace robotskin::world
