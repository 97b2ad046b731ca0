/* SPDX-License-Identifier: Apache-2.0
 * One port: what waits for its tree, what its ticks say, and what goes out next. */
#include "section_unit/port.h"

#include <stddef.h>
#include <string.h>

#include "cell/wire/tags.h"
#include "cell/wire/wave.h"
#include "robotskin/crc.h"
#include "robotskin/operations.h"
#include "section_unit/group_time.h"

uint8_t rs_root_of(const rs_section_unit* unit, unsigned port) {
  return rs_root_number(unit->config.unit, port);
}

rs_wave rs_port_wave(const rs_section_unit* unit, unsigned port) {
  const uint8_t depth_cap = unit->port[port].balance.depth_cap;
  return (rs_wave){.tag = unit->port[port].tag,
                   .sequence = (uint16_t)unit->tick_time,
                   .era = (uint16_t)(unit->tick_time >> 16 & 0x3FFU),
                   .root = rs_root_of(unit, port),
                   .forming = unit->forming,
                   .depth_cap = depth_cap == 0U ? RS_TTL_START : depth_cap,
                   .rate_divisor = unit->port[port].rate.divisor,
                   .gain_threshold = unit->forming ? RS_GAIN_FORMING : RS_GAIN_STEADY};
}

bool rs_port_alive(const rs_unit_port* port, uint64_t now_ns) {
  return port->good > 0U && now_ns - port->heard_ns < (uint64_t)RS_LINK_DOWN_US * 1000U;
}

void rs_ports_power(rs_section_unit* unit, unsigned port, bool on) {
  const uint16_t bit = (uint16_t)(1U << port);
  if (on) {
    unit->power |= bit;
    return;
  }
  unit->power &= (uint16_t)~bit;
  unit->port[port].good = 0;
  unit->port[port].root = false;
  unit->port[port].queue_count = 0;
}

/* The turn that it is now, and its key. */
static void follow_turn(rs_section_unit* unit) {
  const uint32_t turn = (uint32_t)((unit->tick_time >> RS_TICK_TIME_BITS) + unit->config.turns) & RS_TURN_MASK;
  if (unit->config.cell_key == NULL || turn == unit->turn) return;
  uint8_t keys[RS_CELL_KEYS_BYTES];
  rs_cell_keys(unit->config.cell_key, 0, keys);
  rs_key_of_turn(keys, turn, unit->turn_key);
  unit->turn = turn;
}

/* The key of a command: the group's if it is for all, else that of its cell. False if that cell is not known. */
static bool key_of(const rs_section_unit* unit, const rs_command* command, uint8_t key[RS_CELL_KEY_BYTES]) {
  const bool by_uid = command->operation == RS_OPERATION_assign || command->operation == RS_OPERATION_rejoin;
  memcpy(key, unit->turn_key, RS_CELL_KEY_BYTES);
  if (!by_uid && command->target == RS_ID_ALL) return true;
  const uint32_t uid = by_uid ? command->value_low : unit->ids.uid_of[command->target];
  uint8_t keys[RS_CELL_KEYS_BYTES];
  rs_cell_keys(unit->config.cell_key, uid, keys);
  rs_key_of_turn(keys + RS_CELL_KEY_BYTES, unit->turn, key);
  return uid != 0U;
}

static bool tag_command(const rs_section_unit* unit, uint8_t* frame) {
  RS_STATIC_ASSERT((int)RS_grant_tag_AT == (int)RS_command_tag_AT, "their tags cover as much");
  RS_STATIC_ASSERT(RS_command_tag_AT / 8 + 4 == RS_CONTENT_BYTES, "the tag ends a command");
  rs_store32(frame + RS_command_tag_AT / 8, 0U);
  if (unit->config.cell_key == NULL) return true;
  uint8_t key[RS_CELL_KEY_BYTES];
  memcpy(key, unit->turn_key, sizeof key);
  if (rs_frame_type_of(frame) == RS_TYPE_command) {
    rs_command command;
    rs_command_unpack(&command, frame);
    if (command.operation == RS_OPERATION_assign) {
      command.target = unit->turn & ((1U << RS_TURN_LOW_BITS) - 1U);
      command.spare = unit->turn >> RS_TURN_LOW_BITS;
      rs_command_pack(frame, &command);
    }
    if (!key_of(unit, &command, key)) return false;
  }
  rs_store32(frame + RS_command_tag_AT / 8, rs_command_tag(key, frame, (uint32_t)unit->tick_time));
  return true;
}

void rs_ports_send(rs_section_unit* unit, unsigned port, const uint8_t* content) {
  rs_unit_port* here = &unit->port[port];
  if (!here->root || here->queue_count >= RS_UNIT_QUEUE) {
    ++here->dropped;
    ++unit->dropped;
    return;
  }
  uint8_t* frame = here->queue[(here->queue_first + here->queue_count) % RS_UNIT_QUEUE];
  memcpy(frame, content, RS_CONTENT_BYTES);
  follow_turn(unit);
  const bool command = rs_frame_type_of(frame) == RS_TYPE_command || rs_frame_type_of(frame) == RS_TYPE_grant;
  if (command && !tag_command(unit, frame)) {
    ++here->dropped;
    ++unit->dropped;
    return;
  }
  if (rs_frame_type_of(frame) == RS_TYPE_joints) {
    const uint32_t epoch = (uint32_t)(unit->tick_time / RS_EPOCH_TICKS);
    rs_joints joints;
    rs_joints_unpack(&joints, frame);
    joints.epoch = epoch & RS_EPOCH_MASK;
    rs_joints_pack(frame, &joints);
    joints.tag = unit->config.cell_key == NULL ? 0U : rs_joints_tag(unit->turn_key, frame, epoch);
    rs_joints_pack(frame, &joints);
  }
  rs_frame_seal(frame);
  ++here->queue_count;
}

void rs_ports_pack_tick(const rs_section_unit* unit, unsigned port, uint64_t now_ns, uint8_t* frame) {
  const uint64_t time_ns = rs_unit_time(unit, now_ns), start_ns = unit->tick_time * RS_TICK_US * 1000U;
  const uint64_t age_us = time_ns < start_ns ? 0U : (time_ns - start_ns) / 1000U;
  rs_tick tick = {.type = RS_TYPE_tick,
                  .hops = 0,
                  .sender = RS_ID_SECTION_UNIT,
                  .sender_port = port & 3U,
                  .nonce = unit->config.session & 0xFFU,
                  .heard = rs_port_alive(&unit->port[port], now_ns),
                  .ack = rs_arq_receiver_ack(&unit->port[port].arq_receiver),
                  .age_4us = rs_tick_age(age_us > UINT16_MAX ? UINT16_MAX : (uint32_t)age_us)};
  const rs_wave wave = rs_port_wave(unit, port);
  rs_wave_into_tick(&tick, &wave);
  rs_tick_pack(frame, &tick);
  rs_frame_seal(frame);
}

/* Which every cell authenticates, and passes on. */
static bool is_order(const uint8_t* frame) {
  return rs_frame_type_of(frame) == RS_TYPE_command || rs_frame_type_of(frame) == RS_TYPE_joints;
}

/* When the first frame that waits may go down: an order not too soon after the last one. */
static uint64_t down_ns(const rs_unit_port* port) {
  if (port->queue_count == 0U) return UINT64_MAX;
  return is_order(port->queue[port->queue_first % RS_UNIT_QUEUE]) ? port->ordered_ns : 0U;
}

uint64_t rs_ports_due(const rs_section_unit* unit) {
  uint64_t due_ns = UINT64_MAX;
  for (unsigned port = 0; port < unit->config.ports; ++port) {
    const uint64_t port_ns = unit->port[port].busy ? UINT64_MAX : down_ns(&unit->port[port]);
    if (port_ns < due_ns) due_ns = port_ns;
  }
  return due_ns;
}

void rs_ports_transmit(rs_section_unit* unit, uint64_t now_ns, rs_unit_output* output) {
  for (unsigned port = 0; port < unit->config.ports; ++port) {
    rs_unit_port* here = &unit->port[port];
    if (here->busy || (unit->power >> port & 1U) == 0U) continue;
    if (here->tick_due) {
      here->tick_due = false;
      rs_ports_pack_tick(unit, port, now_ns, here->sending);
    } else if (down_ns(here) <= now_ns) {
      const uint8_t* frame = here->queue[here->queue_first % RS_UNIT_QUEUE];
      if (is_order(frame)) here->ordered_ns = now_ns + RS_ORDER_US * 1000U;
      memcpy(here->sending, here->queue[here->queue_first % RS_UNIT_QUEUE], RS_FRAME_BYTES);
      here->queue_first = (uint8_t)((here->queue_first + 1U) % RS_UNIT_QUEUE);
      --here->queue_count;
    } else {
      continue;
    }
    here->busy = true;
    output->frame[port] = here->sending;
  }
}
