/* SPDX-License-Identifier: Apache-2.0 */
#include "kept_keys.h"

#include "flash.h"
#include "robotskin/commissioning.h"
#include "robotskin/receiver.h"
#include "rp2040.h"
#include "serial_lines.h"

enum { PAGE_BYTES = 256, THERE_ARE_KEYS = 1, LOOK_US = 1000 };

/* As the image of a cell that is made with its keys has it. */
typedef struct {
  uint32_t keyed; /* THERE_ARE_KEYS, or an empty flash */
  uint8_t keys[RS_CELL_KEYS_BYTES];
  uint8_t none[PAGE_BYTES - 4 - RS_CELL_KEYS_BYTES];
} page;
RS_STATIC_ASSERT(sizeof(page) == PAGE_BYTES, "one page of the flash");
extern const page rs_keys_start;

const uint8_t* kept_keys(void) {
  const volatile page* kept = &rs_keys_start; /* it changes beneath the compiler */
  return kept->keyed == THERE_ARE_KEYS ? (const uint8_t*)kept->keys : 0;
}

void forget_keys(void) {
  erase_sector(&rs_keys_start);
}

static void keep_keys(const uint8_t* keys) {
  static RS_WORDS page written;
  written.keyed = THERE_ARE_KEYS;
  for (unsigned i = 0; i < (unsigned)RS_CELL_KEYS_BYTES; ++i) written.keys[i] = keys[i];
  for (unsigned i = 0; i < sizeof written.none; ++i) written.none[i] = 0xFF;
  erase_sector(&rs_keys_start); /* what a cut of power left half written */
  write_flash(&rs_keys_start, &written, sizeof written);
}

/* Sleeps until something comes, and at most for a while. */
static void wait(void) {
  REG(TIMER + 0x10) = REG(TIMER + TIMER_RAW) + LOOK_US;
  __asm__ volatile("cpsid i" ::: "memory");
  if (serial_lines_come() == 0U) __asm__ volatile("wfi" ::: "memory");
  __asm__ volatile("cpsie i" ::: "memory");
}

void take_keys(uint32_t uid) {
  static rs_commissioning cell;
  static rs_receiver line[RS_PORTS];
  static RS_WORDS uint8_t answer[RS_PORTS][RS_FRAME_BYTES];
  uint32_t asked_us = REG(TIMER + TIMER_RAW);
  while (cell.kept == 0U || REG(TIMER + TIMER_RAW) - asked_us < (uint32_t)RS_COMMISSIONED_US) {
    wait();
    for (unsigned port = 0; port < (unsigned)RS_PORTS; ++port) {
      const uint8_t* bytes;
      bool idle;
      uint32_t count = serial_lines_receive(port, &bytes, &idle);
      if (idle) rs_receiver_idle(&line[port]);
      for (; count > 0U; --count) {
        uint8_t frame[RS_FRAME_BYTES];
        if (rs_receiver_byte(&line[port], *bytes++, frame) != RS_RECEIVED_FRAME) continue;
        const rs_commissioning_do next = rs_commissioning_frame(&cell, uid, frame, answer[port]);
        if (next == RS_COMMISSIONING_NOTHING) continue;
        if (next == RS_COMMISSIONING_KEEP) keep_keys(cell.keys);
        serial_lines_send(port, answer[port]);
        asked_us = REG(TIMER + TIMER_RAW);
      }
    }
  }
}
