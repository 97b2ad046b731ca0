#include <string.h>

#include "section_unit/unit_parts.h"

static rs_wave wave_of(const rs_section_unit* unit, unsigned port) {
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
    if (unit->config.cell_key != 0) {
      const rs_wave wave = wave_of(unit, port);
      here->tag = rs_wave_tag(&unit->key, &wave);
    }
    if (changed) {
      uint8_t tick[RS_FRAME_BYTES];
      rs_ports_pack_tick(unit, port, now_ns, tick);
      rs_datagrams_gather(unit, port + 1U, tick, now_ns);
    }
  }
}

void rs_ports_send(rs_section_unit* unit, unsigned port, const uint8_t* content) {
  rs_unit_port* here = &unit->port[port];
  if (!here->root || here->queue_count >= RS_UNIT_QUEUE) {
    ++here->dropped;
    ++unit->dropped;
    return;
  }
  uint8_t* frame = here->queue[(here->queue_first + here->queue_count++) % RS_UNIT_QUEUE];
  memcpy(frame, content, RS_CONTENT_BYTES);
  if (rs_frame_type_of(frame) == RS_TYPE_command || rs_frame_type_of(frame) == RS_TYPE_grant) {
    RS_STATIC_ASSERT((int)RS_grant_tag_AT == (int)RS_command_tag_AT, "their tags cover as much");
    RS_STATIC_ASSERT(RS_command_tag_AT / 8 + 4 == RS_CONTENT_BYTES, "the tag ends a command");
    const uint32_t era = (uint32_t)(unit->tick_time >> 16) & 0x3FFU;
    rs_store32(frame + RS_command_tag_AT / 8, unit->config.cell_key == 0 ? 0U : rs_command_tag(&unit->key, frame, era));
  }
  if (rs_frame_type_of(frame) == RS_TYPE_joints) {
    const uint32_t epoch = (uint32_t)(unit->tick_time / RS_EPOCH_TICKS);
    rs_joints joints;
    rs_joints_unpack(&joints, frame);
    joints.epoch = epoch & RS_EPOCH_MASK;
    rs_joints_pack(frame, &joints);
    joints.tag = unit->config.cell_key == 0 ? 0U : rs_joints_tag(&unit->key, frame, epoch);
    rs_joints_pack(frame, &joints);
  }
  rs_frame_seal(frame);
}

static void send_by_uid(rs_section_unit* unit, unsigned port, rs_command command) {
  command.type = RS_TYPE_command;
  command.target = RS_ID_ALL;
  uint8_t content[RS_CONTENT_BYTES];
  rs_command_pack(content, &command);
  rs_ports_send(unit, port, content);
}

static void receive_join(rs_section_unit* unit, unsigned port, const uint8_t* frame) {
  rs_join join;
  rs_join_unpack(&join, frame);
  const uint16_t id = rs_names_give(&unit->names, &unit->config, join.uid, (uint16_t)join.wanted);
  if (id == RS_ID_NONE) return;
  send_by_uid(
      unit, port,
      (rs_command){.operation = RS_OPERATION_assign, .index = id, .value_high = join.challenge, .value_low = join.uid});
}

static void receive_topology(rs_section_unit* unit, unsigned port, const uint8_t* frame) {
  rs_topology topology;
  rs_topology_unpack(&topology, frame);
  if (rs_names_agree(&unit->names, &unit->config, topology.uid, (uint16_t)topology.source)) return;
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
      rs_hearing_start(&here->hearing, tick.echo);
    } else if (rs_hearing_compare(&here->hearing, tick.echo)) {
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
      rs_hearing_count(&here->hearing);
      rs_unit_torque_receive(unit, port, frame, now_ns);
      break;
    case RS_TYPE_event:
      rs_hearing_count(&here->hearing);
      rs_datagrams_gather(unit, port + 1U, frame, now_ns);
      break;
    case RS_TYPE_clock:
    case RS_TYPE_reply:
      rs_datagrams_gather(unit, port + 1U, frame, now_ns);
      break;
    default:
      break;
  }
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
                  .echo = rs_hearing_echo(&unit->port[port].hearing),
                  .age_us = age_us > 0xFFFU ? 0xFFFU : (uint32_t)age_us};
  const rs_wave wave = wave_of(unit, port);
  rs_wave_into_tick(&tick, &wave);
  rs_tick_pack(frame, &tick);
  rs_frame_seal(frame);
}

void rs_ports_transmit(rs_section_unit* unit, uint64_t now_ns, rs_unit_output* output) {
  for (unsigned port = 0; port < unit->config.ports; ++port) {
    rs_unit_port* here = &unit->port[port];
    if (here->busy || (unit->power >> port & 1U) == 0U) continue;
    if (here->tick_due) {
      here->tick_due = false;
      rs_ports_pack_tick(unit, port, now_ns, here->sending);
    } else if (here->queue_count > 0U) {
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
