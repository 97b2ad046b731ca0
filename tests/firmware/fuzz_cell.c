/* SPDX-License-Identifier: Apache-2.0
 * A cell under hostile frames, and one whose memory is damaged. */
#include <stdlib.h>

#include "fuzz.h"
#include "robotskin/crc.h"
#include "robotskin/timing.h"

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

void fuzz_cell(uint32_t steps, bool keyed) {
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

void fuzz_damage(uint32_t steps) {
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
