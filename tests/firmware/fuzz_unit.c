/* SPDX-License-Identifier: Apache-2.0
 * A section unit under hostile frames and datagrams, and the receiver of bytes. */
#include <stdlib.h>

#include "fuzz.h"
#include "robotskin/crc.h"
#include "robotskin/receiver.h"
#include "robotskin/section_unit.h"
#include "robotskin/timing.h"

static void plain_tag(void* context, const uint8_t* bytes, uint32_t count, uint8_t tag[RS_DATAGRAM_TAG_BYTES]) {
  (void)context;
  for (unsigned i = 0; i < RS_DATAGRAM_TAG_BYTES; ++i) tag[i] = (uint8_t)(rs_crc16(bytes, count) >> i % 2U * 8U);
}

/* Records that say the unit is heard, and when. */
static void hostile_peer(uint8_t* records, uint32_t count, const rs_datagram_header* header,
                         const rs_section_unit* unit) {
  if (header->kind != RS_DATAGRAM_KIND_peer || count < 2U || draw() % 8U == 0U) return;
  rs_peer_unit_pack(records,
                    &(rs_peer_unit){.unit = header->unit, .flags = (uint8_t)draw(), .session = header->session});
  rs_peer_unit_pack(records + RS_DATAGRAM_RECORD_BYTES,
                    &(rs_peer_unit){.unit = unit->config.unit,
                                    .session = unit->config.session,
                                    .sent_ns = (uint32_t)unit->peers_due_ns - draw() % 40000000U,
                                    .held_ns = draw() % 20000000U});
}

void fuzz_unit(uint32_t steps, bool keyed) {
  rs_section_unit* unit = calloc(1, sizeof *unit);
  const rs_section_unit_config config = {.group = 3,
                                         .unit = 2,
                                         .ports = 5,
                                         .first_id = 10,
                                         .last_id = 40,
                                         .batch_us = draw() % 2U * 1000U,
                                         .session = 9,
                                         .powered = true,
                                         .tag = keyed ? plain_tag : NULL};
  uint64_t now_ns = (uint64_t)draw() * 1000000U;
  rs_unit_output output;
  rs_unit_input input = {.kind = RS_UNIT_INPUT_BOOT, .config = &config};
  rs_section_unit_step(unit, &input, now_ns, &output);
  uint32_t accepted = 0, named = 0;
  for (uint32_t i = 0; i < steps; ++i) {
    now_ns += draw() % 60000U;
    uint8_t bytes[RS_DATAGRAM_BYTES_MAX];
    input = (rs_unit_input){.kind = RS_UNIT_INPUT_TIMER};
    const uint32_t kind = draw() % 8U;
    if (kind < 4U) {
      for (unsigned b = 0; b < RS_FRAME_BYTES; ++b) bytes[b] = (uint8_t)draw();
      if (draw() % 4U != 0U) bytes[0] = (uint8_t)((bytes[0] & 0x0FU) | (RS_TYPE_tick + draw() % 9U) << 4);
      if (draw() % 8U != 0U) rs_frame_seal(bytes);
      input = (rs_unit_input){.kind = RS_UNIT_INPUT_FRAME, .port = (uint8_t)(draw() % 18U), .bytes = bytes};
    } else if (kind < 6U) {
      input = (rs_unit_input){.kind = RS_UNIT_INPUT_SENT, .port = (uint8_t)(draw() % 18U)};
    } else if (kind == 6U) {
      uint32_t count = draw() % 80U;
      for (unsigned b = 0; b < sizeof bytes; ++b) bytes[b] = (uint8_t)draw();
      const rs_datagram_header header = {.kind = (uint8_t)(draw() % 8U),
                                         .flags = draw() % 8U == 0U ? (uint8_t)draw()
                                                  : keyed           ? RS_DATAGRAM_KEYED
                                                                    : 0,
                                         .unit = draw() % 2U == 0U ? (uint8_t)(draw() % 18U) : RS_UNIT_ALL,
                                         .group = 3,
                                         .session = 1U + draw() % 2U,
                                         .sequence = i - draw() % 3U,
                                         .time_ns = now_ns,
                                         .count = (uint16_t)count,
                                         .answering = draw() % 4U == 0U ? 0U : 9U};
      rs_datagram_header_pack(bytes, &header);
      hostile_peer(bytes + RS_DATAGRAM_HEADER_BYTES, count, &header, unit);
      uint32_t length = RS_DATAGRAM_HEADER_BYTES + RS_DATAGRAM_RECORD_BYTES * count;
      if (keyed && length + RS_DATAGRAM_TAG_BYTES <= sizeof bytes) {
        if (draw() % 4U != 0U) plain_tag(NULL, bytes, length, bytes + length);
        length += RS_DATAGRAM_TAG_BYTES;
      }
      if (length > sizeof bytes || draw() % 8U == 0U) length = draw() % sizeof bytes;
      input = (rs_unit_input){.kind = RS_UNIT_INPUT_DATAGRAM, .bytes = bytes, .count = length};
    }
    const uint32_t refused = unit->refused;
    rs_section_unit_step(unit, &input, now_ns, &output);
    if (input.kind == RS_UNIT_INPUT_DATAGRAM) accepted += unit->refused == refused;
    named += unit->ids.count > 0U;
    /* After a leap of the group's time it is due at once. */
    require((int64_t)(output.timer_ns - now_ns) <= RS_SEQUENCE_WINDOW * 1000000, "the timer comes");
    require(output.datagram == NULL || output.datagram_bytes <= RS_DATAGRAM_BYTES_MAX, "datagrams fit");
    require((output.power >> config.ports) == 0U, "only ports that are there have power");
    if (output.datagram != NULL) {
      rs_datagram_header header;
      require(rs_datagram_header_unpack(&header, output.datagram, output.datagram_bytes) == RS_DATAGRAM_OK,
              "datagrams are well formed");
    }
    for (unsigned port = 0; port < config.ports; ++port) {
      require(unit->port[port].queue_count <= RS_UNIT_QUEUE, "queues are bounded");
      require(unit->port[port].rate.divisor >= 1U && unit->port[port].rate.divisor <= 15U, "a rate divisor is one");
      if (output.frame[port] != NULL) require(rs_frame_intact(output.frame[port]), "frames have a right checksum");
    }
    for (unsigned port = config.ports; port < RS_SECTION_UNIT_PORTS_MAX; ++port) {
      require(output.frame[port] == NULL, "nothing goes out where no port is");
    }
    for (uint32_t id = 0; id < config.first_id; ++id) {
      require((unit->ids.taken[id / 8U] >> (id % 8U) & 1U) == 0U, "only own ids are given");
    }
  }
  require(steps < 100000U || (accepted > 0U && named > 0U), "the fuzzer gets past the doors");
  free(unit);
}

void fuzz_receiver(uint32_t steps) {
  rs_receiver receiver = {0};
  uint8_t frame[RS_FRAME_BYTES];
  for (uint32_t i = 0; i < steps; ++i) {
    if (draw() % 64U == 0U) rs_receiver_idle(&receiver);
    if (rs_receiver_byte(&receiver, (uint8_t)draw(), frame) == RS_RECEIVED_FRAME) {
      require(rs_frame_intact(frame), "a frame found is a frame");
    }
    require(receiver.count <= RS_FRAME_BYTES && receiver.at < RS_FRAME_BYTES, "the ring holds");
  }
}
