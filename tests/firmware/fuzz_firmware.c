/* SPDX-License-Identifier: Apache-2.0
 * Feeds cells and a section unit with frames and datagrams that make no sense, and aborts when an invariant breaks.
 *
 * Usage: fuzz_firmware SEED STEPS. Built with sanitizers by test_hostile_input.py. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "robotskin/cell.h"
#include "robotskin/crc.h"
#include "robotskin/operations.h"
#include "robotskin/receiver.h"
#include "robotskin/section_unit.h"
#include "robotskin/timing.h"

static uint64_t random_state;

static uint32_t draw(void) { /* xorshift64* (Vigna 2016) */
  random_state ^= random_state >> 12;
  random_state ^= random_state << 25;
  random_state ^= random_state >> 27;
  return (uint32_t)((random_state * 0x2545F4914F6CDD1DULL) >> 32);
}

static void require(bool holds, const char* what) {
  if (holds) return;
  fprintf(stderr, "broken: %s\n", what);
  abort();
}

/* Random bytes, with a right checksum most of the time, and often a plausible tick or command. */
static void hostile_frame(uint8_t frame[RS_FRAME_BYTES], uint16_t sequence, const rs_cell* cell) {
  for (unsigned i = 0; i < RS_FRAME_BYTES; ++i) frame[i] = (uint8_t)draw();
  const uint32_t kind = draw() % 9U;
  if (kind < 3U) {
    rs_tick tick;
    rs_tick_unpack(&tick, frame);
    tick.type = RS_TYPE_tick;
    tick.sequence = (sequence + draw() % 24U - 4U) & 0xFFFFU;
    tick.heard = draw() % 8U != 0U;
    tick.parent = draw() % 4U == 0U;
    if (draw() % 4U != 0U) tick.hops = draw() % 6U;
    if (draw() % 16U != 0U) tick.nonce = 7;
    if (draw() % 4U != 0U) tick.gain_threshold = 1;
    rs_tick_pack(frame, &tick);
  } else if (kind == 5U) {
    rs_grant grant;
    rs_grant_unpack(&grant, frame);
    grant.type = RS_TYPE_grant;
    grant.sequence = (cell->route.wave.sequence + draw() % 4U - 2U) & 0xFFFFU;
    grant.root = cell->route.wave.root;
    if (draw() % 2U == 0U) grant.cell = cell->id;
    if (draw() % 2U == 0U) grant.target_root = grant.demand_1_root = cell->route.neighbour[draw() % RS_PORTS].wave.root;
    rs_grant_pack(frame, &grant);
  } else if (kind < 5U) {
    rs_command command;
    rs_command_unpack(&command, frame);
    command.type = RS_TYPE_command;
    command.operation = draw() % 18U;
    command.target = draw() % 2U == 0U ? RS_ID_ALL : cell->id;
    if (draw() % 2U == 0U) command.index = draw() % 12U;
    if (draw() % 2U == 0U) command.value_low = draw() % 2U == 0U ? cell->uid : draw() % 300U;
    if (draw() % 2U == 0U) command.value_high = cell->challenge;
    rs_command_pack(frame, &command);
  } else if (kind == 8U) {
    rs_torque torque;
    rs_torque_unpack(&torque, frame);
    torque.type = RS_TYPE_torque;
    torque.epoch = (sequence / RS_EPOCH_TICKS + draw() % 4U - 2U) & RS_EPOCH_MASK;
    torque.limb = draw() % 4U;
    rs_torque_pack(frame, &torque);
  } else if (kind == 6U) {
    rs_event event;
    rs_event_unpack(&event, frame);
    event.type = RS_TYPE_event;
    event.source = draw() % 4U + 1U;
    rs_event_pack(frame, &event);
  } else if (draw() % 2U == 0U) {
    rs_joints joints;
    rs_joints_unpack(&joints, frame);
    joints.type = RS_TYPE_joints;
    joints.epoch = (sequence / RS_EPOCH_TICKS) & RS_EPOCH_MASK;
    rs_joints_pack(frame, &joints);
  }
  if (draw() % 16U != 0U) rs_frame_seal(frame);
}

static void check_ring(const rs_arq_ring* ring, unsigned size) {
  require(
      ring->confirmed <= ring->sent && ring->sent <= ring->tried && ring->tried <= ring->count && ring->count <= size,
      "what is retained is in order");
}

static void check_cell(const rs_cell* cell, const rs_output* output, uint8_t busy_before, uint32_t now_us) {
  const rs_route* route = &cell->route;
  const rs_queues* queues = &cell->queues;
  require(route->parent_port <= RS_PORTS, "the parent is at a port");
  require((route->parent_port == RS_NO_PARENT) == (route->hops == RS_HOPS_POISON), "hops are poison without a parent");
  require(!route->in_quarantine || route->parent_port == RS_NO_PARENT, "no parent in quarantine");
  require(route->parent_port == RS_NO_PARENT || !route->unbound, "a parent bounds the feasible distance");
  require(route->parent_port == RS_NO_PARENT || route->hops >= route->feasible_hops, "hops are not below the best");
  require(queues->data.count <= RS_QUEUE_DATA, "queues are bounded");
  check_ring(&cell->arq_sender.event, RS_ARQ_EVENTS);
  check_ring(&cell->arq_sender.torque, RS_ARQ_TORQUES);
  require(cell->arq_sender.announcements <= RS_ANNOUNCEMENTS, "announcements are bounded");
  require(cell->torque.used <= RS_TORQUE_SLOTS, "slots are bounded");
  require(queues->slow.count <= RS_QUEUE_SLOW && queues->down.count <= RS_QUEUE_DOWN, "queues are bounded");
  require(output->timer_us - now_us <= RS_TOPOLOGY_US, "the timer comes");
  require(cell->id <= RS_ID_LAST, "an id is one");
  require(cell->settings.mode <= RS_MODE_EVENT, "a mode is one");
  require(!output->sampling || output->sample_us - now_us <= 250000U || now_us - output->sample_us <= 4000000U,
          "the next sample comes");
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    if (output->frame[port] == NULL) continue;
    require((busy_before >> port & 1U) == 0U, "one frame at a time");
    require(rs_frame_intact(output->frame[port]), "what is sent has a right checksum");
  }
}

static void fuzz_cell(uint32_t steps, bool keyed) {
  static const uint8_t secret[RS_CELL_KEY_BYTES] = {1, 2, 3};
  uint8_t keys[RS_CELL_KEYS_BYTES];
  rs_cell_keys(secret, 5, keys);
  rs_cell* cell = calloc(1, sizeof *cell); /* on the heap, so that the sanitizer sees its ends */
  uint32_t now_us = draw();
  const rs_boot boot = {.uid = 5, .random = draw(), .keys = keyed ? keys : NULL};
  rs_output output;
  rs_input input = {.kind = RS_INPUT_BOOT, .boot = &boot};
  rs_cell_step(cell, &input, now_us, &output);
  uint32_t parents = 0;
  for (uint32_t i = 0; i < steps; ++i) {
    now_us += draw() % 4U == 0U ? draw() % 1500U : draw() % 60U;
    if (draw() % 5000U == 0U) now_us += draw() % 3000000U;
    uint8_t frame[RS_FRAME_BYTES];
    rs_sample sample;
    input = (rs_input){.kind = RS_INPUT_TIMER};
    uint8_t busy = cell->queues.busy;
    switch (draw() % 8U) {
      case 0:
        break;
      case 1: {
        for (unsigned c = 0; c < RS_CHANNEL_ALL_COUNT; ++c) sample.value[c] = (int32_t)(draw() >> draw() % 32U);
        input = (rs_input){.kind = RS_INPUT_SAMPLE, .sample = &sample, .fault = draw() % 2U != 0U};
        break;
      }
      case 2:
      case 3:
        input = (rs_input){.kind = RS_INPUT_SENT, .port = (uint8_t)(draw() % 7U)};
        if (input.port >= 1U && input.port <= RS_PORTS) busy &= (uint8_t)~(1U << (input.port - 1U));
        break;
      default:
        hostile_frame(frame, (uint16_t)(now_us / 1000U), cell);
        input = (rs_input){.kind = RS_INPUT_FRAME, .port = (uint8_t)(draw() % 6U), .frame = frame};
        break;
    }
    if (draw() % 50000U == 0U) {
      rs_contribution contribution = {
          .limb = (uint8_t)(draw() % 18U), .parts = (uint8_t)(draw() % 4U), .age = (uint8_t)draw()};
      for (unsigned i = 0; i < RS_TORQUE_PARTS * RS_JOINTS_PER_PART; ++i) contribution.joint[i] = (int32_t)draw();
      rs_cell_contribute(cell, &contribution);
    }
    if (draw() % 100000U == 0U) {
      input = (rs_input){.kind = RS_INPUT_BOOT, .boot = &boot};
      busy = 0;
    }
    for (unsigned port = 0; port < RS_PORTS; ++port) {
      if (now_us - cell->queues.started_us[port] >= RS_SENDING_US) busy &= (uint8_t)~(1U << port);
    }
    rs_cell_step(cell, &input, now_us, &output);
    check_cell(cell, &output, busy, now_us);
    parents += cell->route.parent_port != RS_NO_PARENT;
    require(!keyed || (cell->counts.parent_changes == 0U && cell->id == RS_ID_NONE && cell->led_rgb == 0U),
            "with a key nothing unauthenticated is acted upon");
  }
  require(keyed || steps < 100000U || parents > steps / 200U, "the fuzzer gets past the doors");
  free(cell);
}

/* Memory that is damaged anywhere: nothing undefined is done with it, and the tree state heals. */
static void fuzz_damage(uint32_t steps) {
  rs_cell* cell = calloc(1, sizeof *cell);
  uint32_t now_us = draw();
  const rs_boot boot = {.uid = 5, .random = draw()};
  rs_output output = {.restart = true};
  rs_input input;
  uint8_t frame[RS_FRAME_BYTES];
  for (uint32_t i = 0; i < steps; ++i) {
    now_us += draw() % 60U;
    if (output.restart || draw() % 4096U == 0U) {
      input = (rs_input){.kind = RS_INPUT_BOOT, .boot = &boot};
    } else if (draw() % 4U == 0U) {
      input = (rs_input){.kind = RS_INPUT_SENT, .port = (uint8_t)(1U + draw() % RS_PORTS)};
    } else if (draw() % 2U == 0U) {
      input = (rs_input){.kind = RS_INPUT_TIMER};
    } else {
      hostile_frame(frame, (uint16_t)(now_us / 1000U), cell);
      input = (rs_input){.kind = RS_INPUT_FRAME, .port = (uint8_t)(1U + draw() % RS_PORTS), .frame = frame};
    }
    rs_cell_step(cell, &input, now_us, &output);
    if (draw() % 256U == 0U) {
      uint8_t* bytes = draw() % 2U == 0U ? (uint8_t*)cell : (uint8_t*)&cell->route;
      const uint32_t size = bytes == (uint8_t*)cell ? sizeof *cell : sizeof cell->route;
      for (uint32_t k = 1U << draw() % 10U; k > 0U; --k) bytes[draw() % size] = (uint8_t)draw();
    }
  }
  free(cell);
}

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

static void fuzz_unit(uint32_t steps, bool keyed) {
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

static void fuzz_receiver(uint32_t steps) {
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

/* ---- Both ways through a step (cell/fast_path.h) ---- */

/* A frame that a living neighbour could send: port 1 the parent, 2 and 3 children, 4 beside the cell. */
static void lively_frame(uint8_t frame[RS_FRAME_BYTES], unsigned port, uint32_t now_us, const rs_cell* cell) {
  const uint32_t kind = draw() % 512U;
  memset(frame, 0, RS_FRAME_BYTES);
  if (kind < 224U) {
    const uint32_t age_us = now_us % RS_TICK_US;
    const rs_tick tick = {
        .type = RS_TYPE_tick,
        .sequence = (now_us / RS_TICK_US - (draw() % 16U == 0U)) & 0xFFFFU,
        .hops = port == 1U   ? 1U
                : port == 4U ? 1U + draw() % 64U / 62U
                             : 3U,
        .root = 0x11,
        .sender = 10U + port,
        .sender_port = port - 1U,
        .nonce = port + (draw() % 4096U == 0U),
        .parent = port == 2U || port == 3U,
        .heard = draw() % 2048U != 0U,
        .draining = draw() % 2048U == 0U,
        .depth_cap = 20,
        .gain_threshold = 4,
        .ack = port == 2U || port == 3U ? cell->route.neighbour[port - 1U].arq_receiver.next : draw() % 128U,
        .age_us = age_us};
    rs_tick_pack(frame, &tick);
  } else if (kind < 511U) {
    const rs_clock sample = {.type = RS_TYPE_clock,
                             .source = 20U + draw() % 4U,
                             .sequence = draw() % 256U,
                             .ttl = draw() % 64U,
                             .proximity = draw() & 0xFFFFU};
    rs_clock_pack(frame, &sample);
  } else {
    hostile_frame(frame, (uint16_t)(now_us / RS_TICK_US), cell);
    return;
  }
  rs_frame_seal(frame);
  if (draw() % 256U == 0U) frame[draw() % RS_FRAME_BYTES] ^= (uint8_t)(1U << draw() % 8U);
}

/* What the short way notes for itself is no part of what a cell is. */
static void forget_notes(rs_cell* cell) {
  cell->queues.calm_us = 0;
  cell->queues.parent_port = cell->queues.parent_bit = cell->queues.samples_alone = 0;
}

static void compare_ways(const rs_cell* cell, const rs_output* output, const rs_cell* same, const rs_output* expected) {
  static rs_cell one, other;
  one = *cell;
  other = *same;
  forget_notes(&one);
  forget_notes(&other);
  require(memcmp(&one, &other, sizeof one) == 0, "the short way leaves the same cell");
  require(output->timer_us == expected->timer_us && output->sampling == expected->sampling &&
              (!output->sampling || output->sample_us == expected->sample_us) && output->waiting == expected->waiting &&
              output->restart == expected->restart && output->led_changed == expected->led_changed &&
              output->flash_changed == expected->flash_changed,
          "the short way asks for the same");
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    require(
        (output->frame[port] != NULL) == (expected->frame[port] != NULL) &&
            (output->frame[port] == NULL || memcmp(output->frame[port], expected->frame[port], RS_FRAME_BYTES) == 0),
        "the short way sends the same");
  }
}

/* Two cells hear the same; one of them never finds itself calm, and so goes the long way. */
static void fuzz_ways(uint32_t steps) {
  rs_cell* cell = calloc(1, sizeof *cell);
  rs_cell* same = calloc(1, sizeof *same);
  uint32_t now_us = 0, calm = 0;
  const rs_boot boot = {.uid = 5, .random = draw()};
  rs_output output, expected;
  rs_input input = {.kind = RS_INPUT_BOOT, .boot = &boot};
  uint8_t frame[RS_FRAME_BYTES];
  for (uint32_t i = 0; i < steps; ++i) {
    rs_sample sample = {{0}};
    if (i > 0U) {
      now_us += draw() % 40U;
      input = (rs_input){.kind = RS_INPUT_TIMER, .sent = (uint8_t)(draw() % 16U == 0U ? cell->queues.busy : 0U)};
      const uint32_t kind = draw() % 16U;
      if (kind < 9U) {
        input.kind = RS_INPUT_FRAME;
        input.port = (uint8_t)(1U + draw() % RS_PORTS);
        input.frame = frame;
        lively_frame(frame, input.port, now_us, cell);
      } else if (kind < 14U) {
        input.kind = RS_INPUT_SENT;
        input.port = (uint8_t)(draw() % 6U);
      } else if (kind == 14U && output.sampling && (int32_t)(now_us - output.sample_us) >= 0) {
        input.kind = RS_INPUT_SAMPLE;
        input.sample = &sample;
      }
      if (draw() % 32768U == 0U) input = (rs_input){.kind = RS_INPUT_BOOT, .boot = &boot};
    }
    calm += now_us < cell->queues.calm_us && input.kind != RS_INPUT_TIMER;
    forget_notes(same);
    same->queues.calm_us = now_us;
    rs_cell_step(cell, &input, now_us, &output);
    rs_cell_step(same, &input, now_us, &expected);
    compare_ways(cell, &output, same, &expected);
  }
  require(steps < 10000U || calm > steps / 3U, "the short way is taken");
  free(cell);
  free(same);
}

int main(int count, char** arguments) {
  if (count != 3) return 2;
  random_state = strtoull(arguments[1], NULL, 10) * 2U + 1U;
  for (unsigned i = 0; i < 10U; ++i) draw();
  const uint32_t steps = (uint32_t)strtoul(arguments[2], NULL, 10);
  fuzz_cell(steps, false);
  fuzz_cell(steps, true);
  fuzz_damage(steps);
  fuzz_unit(steps / 4U, false);
  fuzz_unit(steps / 4U, true);
  fuzz_receiver(steps);
  fuzz_ways(steps / 4U);
  return 0;
}
