/* SPDX-License-Identifier: Apache-2.0
 * Frames on their way to the host: gathered, and completed as datagrams. */
#include "section_unit/uplink.h"

#include <stddef.h>
#include <string.h>

#include "section_unit/group_time.h"

enum { NS_PER_MS = 1000000 };

bool rs_host_listens(const rs_section_unit* unit, uint64_t now_ns) {
  if (unit->config.unasked) return true;
  return unit->host_heard && now_ns - unit->host_heard_ns < (uint64_t)RS_UNIT_SILENCE_MS * NS_PER_MS;
}

void rs_datagrams_gather(rs_section_unit* unit, unsigned port, const uint8_t* frame, uint64_t now_ns) {
  if (!rs_host_listens(unit, now_ns)) return;
  if (unit->waiting >= RS_DATAGRAM_RECORDS_MAX) {
    ++unit->dropped;
    return;
  }
  uint8_t* record = unit->record[unit->waiting];
  memcpy(record, frame, RS_CONTENT_BYTES);
  rs_record_arrival_pack(record, port, 0);
  unit->arrival_ns[unit->waiting++] = now_ns;
}

void rs_datagram_finish(rs_section_unit* unit, rs_datagram_kind kind, uint32_t count, uint64_t now_ns,
                        rs_unit_output* output) {
  const bool to_host = kind != RS_DATAGRAM_KIND_peer;
  const rs_datagram_header header = {.kind = (uint8_t)kind,
                                     .flags = unit->config.tag != NULL ? RS_DATAGRAM_KEYED : 0,
                                     .unit = unit->config.unit,
                                     .group = unit->config.group,
                                     .session = unit->config.session,
                                     .sequence = to_host ? unit->sequence++ : unit->peers_sequence++,
                                     .time_ns = rs_unit_time(unit, now_ns),
                                     .count = (uint16_t)count,
                                     .dropped = unit->dropped,
                                     .answering = to_host ? unit->host_session : 0U};
  rs_datagram_header_pack(unit->datagram, &header);
  uint32_t bytes = RS_DATAGRAM_HEADER_BYTES + count * RS_DATAGRAM_RECORD_BYTES;
  if (unit->config.tag != NULL) {
    unit->config.tag(unit->config.tag_context, unit->datagram, bytes, unit->datagram + bytes);
    bytes += RS_DATAGRAM_TAG_BYTES;
  }
  output->datagram = unit->datagram;
  output->datagram_bytes = bytes;
}
