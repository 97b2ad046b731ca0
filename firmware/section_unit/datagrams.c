/* SPDX-License-Identifier: Apache-2.0
 * Datagrams to the host and from it. */
#include "section_unit/datagrams.h"

#include <stddef.h>
#include <string.h>

#include "robotskin/operations.h"
#include "section_unit/peers.h"
#include "section_unit/port.h"
#include "section_unit/rate.h"
#include "section_unit/uplink.h"

enum { NS_PER_US = 1000, NS_PER_MS = 1000000 };

static void send_waiting(rs_section_unit* unit, uint64_t now_ns, rs_unit_output* output) {
  uint8_t* record = unit->datagram + RS_DATAGRAM_HEADER_BYTES;
  for (uint32_t i = 0; i < unit->waiting; ++i, record += RS_DATAGRAM_RECORD_BYTES) {
    memcpy(record, unit->record[i], RS_DATAGRAM_RECORD_BYTES);
    const uint64_t age_us = (now_ns - unit->arrival_ns[i]) / NS_PER_US;
    rs_record_arrival_pack(record, rs_record_port(record), age_us > 0xFFFU ? 0xFFFU : (uint32_t)age_us);
  }
  rs_datagram_finish(unit, RS_DATAGRAM_KIND_frames, unit->waiting, now_ns, output);
  unit->waiting = 0;
  unit->hurry = false;
}

/* The state of the unit: last counter and tick time, then of each port the cell there, the size of its tree and what
 * its ticks say. */
static void send_heartbeat(rs_section_unit* unit, uint64_t now_ns, rs_unit_output* output) {
  uint8_t* record = unit->datagram + RS_DATAGRAM_HEADER_BYTES;
  uint32_t count = 0;
  const rs_reply reply = {.type = RS_TYPE_reply,
                          .source = RS_ID_SECTION_UNIT,
                          .operation = RS_OPERATION_ping,
                          .counter = unit->command_counter,
                          .value_low = (uint32_t)unit->tick_time,
                          .version = RS_FIRMWARE_VERSION};
  rs_reply_pack(record, &reply);
  rs_record_arrival_pack(record, 0, 0);
  ++count;
  for (unsigned port = 0; port < unit->config.ports; ++port) {
    const rs_unit_port* here = &unit->port[port];
    uint32_t errors = 0;
    for (uint32_t lost = here->lost; lost != 0U && errors < 7U; lost >>= 1) ++errors;
    const rs_topology topology = {.type = RS_TYPE_topology,
                                  .source = RS_ID_SECTION_UNIT,
                                  .neighbour_1 = here->cell,
                                  .neighbour_port_1 = here->cell == RS_ID_NONE ? 0U : (here->cell_port - 1U) & 3U,
                                  .errors_1 = errors};
    record += RS_DATAGRAM_RECORD_BYTES;
    rs_topology_pack(record, &topology);
    rs_record_arrival_pack(record, port + 1U, 0);
    const rs_status status = {.type = RS_TYPE_status, .sender = here->cell, .size = here->size, .height = here->height};
    record += RS_DATAGRAM_RECORD_BYTES;
    rs_status_pack(record, &status);
    rs_record_arrival_pack(record, port + 1U, 0);
    record += RS_DATAGRAM_RECORD_BYTES;
    rs_ports_pack_tick(unit, port, now_ns, record);
    rs_record_arrival_pack(record, port + 1U, 0);
    count += 3;
  }
  rs_datagram_finish(unit, RS_DATAGRAM_KIND_heartbeat, count, now_ns, output);
}

uint64_t rs_datagrams_send(rs_section_unit* unit, uint64_t now_ns, rs_unit_output* output) {
  if (!rs_host_listens(unit, now_ns)) {
    unit->waiting = 0;
    return unit->heartbeat_ns = now_ns + (uint64_t)RS_KEEP_ALIVE_MS * NS_PER_MS;
  }
  const uint64_t batch_ns = (uint64_t)unit->config.batch_us * NS_PER_US;
  const bool full = unit->waiting == RS_DATAGRAM_RECORDS_MAX;
  if (unit->waiting > 0U && (full || unit->hurry || now_ns - unit->arrival_ns[0] >= batch_ns)) {
    send_waiting(unit, now_ns, output);
  } else if (now_ns >= unit->heartbeat_ns) {
    unit->heartbeat_ns = now_ns + (uint64_t)RS_KEEP_ALIVE_MS * NS_PER_MS;
    send_heartbeat(unit, now_ns, output);
  }
  uint64_t due_ns = unit->heartbeat_ns < now_ns ? now_ns : unit->heartbeat_ns;
  if (unit->waiting > 0U && unit->arrival_ns[0] + batch_ns < due_ns) due_ns = unit->arrival_ns[0] + batch_ns;
  return due_ns;
}

static bool tags_match(const rs_section_unit* unit, const uint8_t* bytes, uint32_t count) {
  uint8_t expected[RS_DATAGRAM_TAG_BYTES];
  const uint32_t covered = count - RS_DATAGRAM_TAG_BYTES;
  unit->config.tag(unit->config.tag_context, bytes, covered, expected);
  uint8_t difference = 0;
  for (unsigned i = 0; i < RS_DATAGRAM_TAG_BYTES; ++i) difference |= (uint8_t)(expected[i] ^ bytes[covered + i]);
  return difference == 0U;
}

/* Whether a datagram is of this group and made by a holder of the key. */
static bool genuine(const rs_section_unit* unit, const rs_datagram_header* header, const uint8_t* bytes,
                    uint32_t count) {
  const bool keyed = unit->config.tag != NULL;
  if (header->group != unit->config.group || header->session == 0U) return false;
  if (((header->flags & RS_DATAGRAM_KEYED) != 0) != keyed) return false;
  return !keyed || tags_match(unit, bytes, count);
}

/* Whether a genuine datagram comes from the host, is for this unit, and is not one played again. */
static bool accept(rs_section_unit* unit, const rs_datagram_header* header) {
  const rs_section_unit_config* config = &unit->config;
  if (header->unit != config->unit && header->unit != RS_UNIT_ALL) return false;
  if (header->kind < RS_DATAGRAM_KIND_keep_alive) return false;
  const bool keyed = config->tag != NULL;
  const bool same_session = header->session == unit->host_session;
  if (same_session) {
    const uint32_t ahead = header->sequence - unit->host_sequence;
    if (ahead == 0U || ahead >= 0x80000000U) return false;
  } else if (keyed && unit->host_session != 0U && header->time_ns <= unit->host_time_ns) {
    return false; /* a session of before */
  }
  if (keyed && header->answering != config->session) {
    if (header->answering != 0U || header->kind != RS_DATAGRAM_KIND_keep_alive) return false;
    if (same_session) unit->host_sequence = header->sequence; /* one that is played again opens nothing */
    return true;
  }
  unit->host_session = header->session;
  unit->host_sequence = header->sequence;
  unit->host_time_ns = header->time_ns;
  return true;
}

static void inject(rs_section_unit* unit, uint32_t to_port, const uint8_t* content) {
  const rs_frame_type type = rs_frame_type_of(content);
  if (type != RS_TYPE_command && type != RS_TYPE_joints) {
    ++unit->refused;
    return;
  }
  if (type == RS_TYPE_command) {
    rs_command command;
    rs_command_unpack(&command, content);
    unit->command_counter = (uint16_t)command.counter;
    if (command.operation == RS_OPERATION_clock_rate || command.operation == RS_OPERATION_mode) {
      for (unsigned port = 0; port < unit->config.ports; ++port) rs_rate_forget(&unit->port[port].rate);
    }
  }
  for (unsigned port = 0; port < unit->config.ports; ++port) {
    if (to_port == 0U ? unit->port[port].root : to_port == port + 1U) rs_ports_send(unit, port, content);
  }
}

void rs_datagrams_receive(rs_section_unit* unit, const uint8_t* bytes, uint32_t count, uint64_t now_ns) {
  rs_datagram_header header;
  if (rs_datagram_header_unpack(&header, bytes, count) != RS_DATAGRAM_OK || !genuine(unit, &header, bytes, count)) {
    ++unit->refused;
    return;
  }
  if (header.kind == RS_DATAGRAM_KIND_peer) {
    if (!rs_peers_receive(unit, &header, bytes, now_ns)) ++unit->refused;
    return;
  }
  if (!accept(unit, &header)) {
    ++unit->refused;
    return;
  }
  unit->host_heard = true;
  unit->host_heard_ns = now_ns;
  if (header.kind == RS_DATAGRAM_KIND_keep_alive) return;
  const uint8_t* record = bytes + RS_DATAGRAM_HEADER_BYTES;
  for (uint32_t i = 0; i < header.count; ++i, record += RS_DATAGRAM_RECORD_BYTES) {
    const uint32_t to_port = rs_record_port(record);
    if (to_port > unit->config.ports) {
      ++unit->refused;
    } else if (header.kind == RS_DATAGRAM_KIND_inject) {
      inject(unit, to_port, record);
    } else if (record[0] > 1U) {
      ++unit->refused;
    } else {
      for (unsigned port = 0; port < unit->config.ports; ++port) {
        if (to_port == 0U || to_port == port + 1U) rs_ports_power(unit, port, record[0] == 1U);
      }
    }
  }
}
