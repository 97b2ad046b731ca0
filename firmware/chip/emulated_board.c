/* SPDX-License-Identifier: Apache-2.0
 * The board of the emulator: registers in a page of memory, which lab/python/robotskin_lab/chip/emulated_cell.py keeps.
 *
 * It stands where a real port has its peripherals, and does what a small port would: received bytes that direct memory
 * access has put somewhere, a start of transmission, two alarms, and sleep. */
#include "board.h"

typedef struct {
  volatile uint32_t events; /* as of board.h */
  volatile uint32_t now_us;
  volatile uint32_t sent;
  volatile uint32_t uid, random;
  volatile uint32_t kept, keyed; /* not 0: there is an image, keys */
  volatile uint32_t fault;
  volatile int32_t channel[RS_CHANNEL_COUNT];
  volatile uint32_t count[RS_PORTS]; /* bytes received since this was last asked */
  volatile uint32_t idle;            /* bit p - 1: the line was idle before them */
  uint8_t bytes[RS_PORTS][RS_FRAME_BYTES];
  volatile uint8_t keys[RS_CELL_KEYS_BYTES];
  volatile uint32_t step_us, late_us;
} inward;

typedef struct {
  volatile uint32_t timer_us, sampling, sample_us, wanted;
  volatile uint32_t started; /* bit p - 1: `frame` is new */
  volatile uint32_t frame[RS_PORTS];
  volatile uint32_t light, lit;
  volatile uint32_t keep, restart;
} outward;

static inward* const in = (inward*)0x40000000U;

extern const uint8_t rs_kept_start[];

/* The page's address in a register, from which all its words are in reach. */
static inline outward* outside(void) {
  outward* out = (outward*)0x40001000U;
  __asm__("" : "+l"(out));
  return out;
}

void rs_board_start(rs_boot* boot) {
  boot->uid = in->uid;
  boot->random = in->random;
  boot->flash = in->kept != 0U ? rs_kept_start : 0;
  boot->keys = in->keyed != 0U ? (const uint8_t*)in->keys : 0;
  boot->step_us = (uint16_t)in->step_us;
}

uint32_t rs_board_now_us(void) {
  return in->now_us;
}

void rs_board_alarms(uint32_t timer_us, bool sampling, uint32_t sample_us, uint32_t wanted) {
  outward* out = outside();
  out->timer_us = timer_us;
  out->sampling = sampling;
  out->sample_us = sample_us;
  out->wanted = wanted;
}

void rs_board_wanted(uint32_t wanted) {
  outside()->wanted = wanted;
}

RS_NOINLINE RS_HOT uint32_t rs_board_wait(void) {
  /* The emulator stops at the first instruction, and goes on at the second when something has happened. So there is one
   * such place, in a function apart. */
  __asm__ volatile(".global rs_board_asleep\nrs_board_asleep:\n wfi" ::: "memory");
  const uint32_t events = in->events;
  in->events = 0;
  return events;
}

uint32_t rs_board_receive(unsigned port, const uint8_t** bytes, bool* idle) {
  const uint32_t count = in->count[port];
  in->count[port] = 0;
  *bytes = in->bytes[port];
  *idle = (in->idle >> port & 1U) != 0U;
  return count;
}

uint32_t rs_board_late_us(unsigned port) {
  (void)port;
  return in->late_us;
}

void rs_board_send(unsigned port, const uint8_t* frame) {
  outward* out = outside();
  out->frame[port] = (uint32_t)(uintptr_t)frame;
  out->started |= 1U << port;
}

uint32_t rs_board_sent(void) {
  const uint32_t sent = in->sent;
  in->sent = 0;
  return sent;
}

bool rs_board_sense(rs_sample* sample) {
  for (unsigned c = 0; c < RS_CHANNEL_COUNT; ++c) sample->value[c] = in->channel[c];
  /* Further channels, if there are any, read the clock. */
  for (int c = RS_CHANNEL_COUNT; c < (int)RS_CHANNEL_ALL_COUNT; ++c) sample->value[c] = (int32_t)(in->now_us & 0xFFU);
  return in->fault != 0U;
}

void rs_board_light(uint32_t rgb) {
  outward* out = outside();
  out->light = rgb;
  out->lit = 1;
}

void rs_board_keep(const uint8_t* flash) {
  outward* out = outside();
  out->keep = (uint32_t)(uintptr_t)flash;
}

void rs_board_restart(void) {
  outward* out = outside();
  out->restart = 1;
}
