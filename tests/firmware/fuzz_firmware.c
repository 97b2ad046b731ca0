/* SPDX-License-Identifier: Apache-2.0
 * Feeds cells and a section unit with frames and datagrams that make no sense, and aborts when an invariant breaks.
 *
 * Usage: fuzz_firmware SEED STEPS. Built with sanitizers by test_hostile_input.py, from all fuzz*.c. */
#include <stdio.h>
#include <stdlib.h>

#include "fuzz.h"
#include "robotskin/crc.h"
#include "robotskin/timing.h"

static uint64_t random_state;

void seed_chance(uint64_t seed) {
  random_state = seed * 2U + 1U;
  for (unsigned i = 0; i < 10U; ++i) draw();
}

uint32_t draw(void) { /* xorshift64* (Vigna 2016) */
  random_state ^= random_state >> 12;
  random_state ^= random_state << 25;
  random_state ^= random_state >> 27;
  return (uint32_t)((random_state * 0x2545F4914F6CDD1DULL) >> 32);
}

void require(bool holds, const char* what) {
  if (holds) return;
  fprintf(stderr, "broken: %s\n", what);
  abort();
}

void hostile_frame(uint8_t frame[RS_FRAME_BYTES], uint16_t sequence, const rs_cell* cell) {
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

int main(int count, char** arguments) {
  if (count != 3) return 2;
  seed_chance(strtoull(arguments[1], NULL, 10));
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
