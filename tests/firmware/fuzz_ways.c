/* SPDX-License-Identifier: Apache-2.0
 * Both ways through a step of a cell (cell/fast_path.h) do the same. */
#include <stdlib.h>
#include <string.h>

#include "fuzz.h"
#include "robotskin/crc.h"
#include "robotskin/timing.h"

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
        .age_4us = rs_tick_age(age_us)};
    rs_tick_pack(frame, &tick);
  } else if (kind < 300U) {
    const rs_event event = {.type = RS_TYPE_event,
                            .source = 20U + draw() % 4U,
                            .sequence = draw() % 8U,
                            .ttl = draw() % 64U,
                            .retransmitted = draw() % 8U == 0U,
                            .sample_tick = now_us / RS_TICK_US % 16U};
    rs_event_pack(frame, &event);
  } else if (kind < 330U) {
    const rs_reply reply = {.type = RS_TYPE_reply, .source = 20U + draw() % 4U, .ttl = draw() % 64U};
    const rs_topology topology = {.type = RS_TYPE_topology, .ttl = draw() % 64U, .uid = 20U + draw() % 64U};
    const rs_join join = {.type = RS_TYPE_join, .ttl = draw() % 64U, .uid = 20U + draw() % 64U};
    if (kind < 310U) {
      rs_reply_pack(frame, &reply);
    } else if (kind < 320U) {
      rs_topology_pack(frame, &topology);
    } else {
      rs_join_pack(frame, &join);
    }
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
  cell->queues.parent_port = cell->queues.parent_bit = cell->queues.samples_next = 0;
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

void fuzz_ways(uint32_t steps) {
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
