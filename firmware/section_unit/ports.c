/* SPDX-License-Identifier: Apache-2.0
 * What comes up at the ports and what each tick asks of them. */
#include "section_unit/ports.h"

#include <stddef.h>

#include "cell/wire/tags.h"
#include "robotskin/crc.h"
#include "robotskin/operations.h"
#include "section_unit/balance.h"
#include "section_unit/group_time.h"
#include "section_unit/id_allocator.h"
#include "section_unit/peers.h"
#include "section_unit/port.h"
#include "section_unit/rate.h"
#include "section_unit/torque.h"
#include "section_unit/uplink.h"

void rs_ports_tick(rs_section_unit* unit, uint64_t now_ns) {
  /* The group's time may be pulled back a little; a tick is never sent again. */
  const uint64_t behind = unit->tick_time - rs_unit_time(unit, now_ns) / (RS_TICK_US * 1000U);
  if (behind < RS_SEQUENCE_WINDOW) return;
  unit->tick_time -= behind;
  rs_peers_keep_time(unit, now_ns);
  rs_balance_tick(unit, now_ns);
  for (unsigned port = 0; port < unit->config.ports; ++port) {
    rs_unit_port* here = &unit->port[port];
    if (!rs_port_alive(here, now_ns)) {
      here->good = 0;
      here->root = false;
      here->cell = RS_ID_NONE;
      here->size = 0;
      here->height = 0;
    }
    const bool changed = rs_rate_tick(&here->rate, here->root ? here->size : 0U);
    here->tick_due = (unit->power >> port & 1U) != 0U;
    if (unit->config.cell_key != NULL) {
      const rs_wave wave = rs_port_wave(unit, port);
      here->tag = rs_wave_tag(&unit->key, &wave);
    }
    if (changed) {
      uint8_t tick[RS_FRAME_BYTES];
      rs_ports_pack_tick(unit, port, now_ns, tick);
      rs_datagrams_gather(unit, port + 1U, tick, now_ns);
    }
  }
}

/* Whether the same already waits to go down: where many ask for an id at once, some ask again before their turn. */
static bool waits(const rs_unit_port* here, const rs_command* command) {
  for (unsigned i = 0; i < here->queue_count; ++i) {
    const uint8_t* frame = here->queue[(here->queue_first + i) % RS_UNIT_QUEUE];
    if (rs_frame_type_of(frame) != RS_TYPE_command) continue;
    rs_command other;
    rs_command_unpack(&other, frame);
    if (other.operation == command->operation && other.value_low == command->value_low &&
        other.value_high == command->value_high && other.index == command->index) {
      return true;
    }
  }
  return false;
}

static void send_by_uid(rs_section_unit* unit, unsigned port, rs_command command) {
  if (waits(&unit->port[port], &command)) return;
  command.type = RS_TYPE_command;
  command.target = RS_ID_ALL;
  uint8_t content[RS_CONTENT_BYTES];
  rs_command_pack(content, &command);
  rs_ports_send(unit, port, content);
}

static void receive_join(rs_section_unit* unit, unsigned port, const uint8_t* frame) {
  rs_join join;
  rs_join_unpack(&join, frame);
  const uint16_t id = rs_ids_give(&unit->ids, &unit->config, join.uid, (uint16_t)join.wanted);
  if (id == RS_ID_NONE) return;
  send_by_uid(unit, port,
              (rs_command){.operation = RS_OPERATION_assign,
                           .counter = unit->command_counter,
                           .index = id,
                           .value_high = join.challenge,
                           .value_low = join.uid});
}

static void receive_topology(rs_section_unit* unit, unsigned port, const uint8_t* frame) {
  rs_topology topology;
  rs_topology_unpack(&topology, frame);
  if (rs_ids_agree(&unit->ids, &unit->config, topology.uid, (uint16_t)topology.source)) return;
  send_by_uid(unit, port,
              (rs_command){.operation = RS_OPERATION_rejoin, .index = topology.source, .value_low = topology.uid});
}

static void receive_tick(rs_unit_port* here, const uint8_t* frame, uint64_t now_ns) {
  rs_tick tick;
  rs_tick_unpack(&tick, frame);
  const bool rebooted = !here->met || here->nonce != tick.nonce;
  here->met = true;
  here->nonce = (uint8_t)tick.nonce;
  if (rebooted || here->sequence != tick.sequence) here->turned_ns = now_ns;
  here->sequence = (uint16_t)tick.sequence;
  /* A stuck cell says the same for ever; what hung on it has long gone elsewhere. */
  if (now_ns - here->turned_ns >= (uint64_t)RS_STALE_LIMIT_US * 1000U) tick.parent = 0;
  if (tick.parent != 0U) {
    if (!here->root || rebooted) {
      rs_arq_receiver_start(&here->arq_receiver, tick.ack);
    } else if (rs_arq_receiver_compare(&here->arq_receiver, tick.ack)) {
      here->tick_due = true;
    }
  }
  here->cell = (uint16_t)tick.sender;
  here->cell_port = (uint8_t)(tick.sender_port + 1U);
  here->root = tick.parent != 0U;
  if (!here->root) here->size = here->height = 0;
}

void rs_ports_receive(rs_section_unit* unit, unsigned port, const uint8_t* frame, uint64_t now_ns) {
  rs_unit_port* here = &unit->port[port];
  if ((unit->power >> port & 1U) == 0U) return;
  if (!rs_frame_intact(frame)) {
    ++here->lost;
    return;
  }
  ++here->frames;
  here->heard_ns = now_ns;
  here->good = 1;
  rs_rate_heard(&here->rate, frame);
  switch (rs_frame_type_of(frame)) {
    case RS_TYPE_tick:
      receive_tick(here, frame, now_ns);
      break;
    case RS_TYPE_status: {
      rs_status status;
      rs_status_unpack(&status, frame);
      here->size = (uint16_t)status.size;
      here->height = (uint8_t)status.height;
      rs_balance_status(unit, port, &status);
      break;
    }
    case RS_TYPE_join:
      receive_join(unit, port, frame);
      break;
    case RS_TYPE_topology:
      receive_topology(unit, port, frame);
      rs_datagrams_gather(unit, port + 1U, frame, now_ns);
      break;
    case RS_TYPE_torque:
      rs_arq_receiver_count(&here->arq_receiver);
      rs_unit_torque_receive(unit, port, frame, now_ns);
      break;
    case RS_TYPE_event:
      rs_arq_receiver_count(&here->arq_receiver);
      rs_datagrams_gather(unit, port + 1U, frame, now_ns);
      break;
    case RS_TYPE_clock:
    case RS_TYPE_reply:
    case RS_TYPE_further:
      rs_datagrams_gather(unit, port + 1U, frame, now_ns);
      break;
    default:
      break;
  }
}
