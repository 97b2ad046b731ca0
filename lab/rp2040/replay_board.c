/* SPDX-License-Identifier: Apache-2.0
 * A board that answers as an emulated Pico's did, and compares what the program asks of it: the host-built program must
 * ask the same, byte by byte. In: environment LOG (a record), UID, KEYS (hex, or empty). Out: counts; status 1 if
 * anything differs. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "board.h"

enum { KINDS = 16 };
static unsigned long differences, calls[KINDS], line_number;
static FILE* record;
static char text[4096];

static void finish(void) {
  printf(
      "{\"clock\": %lu, \"received\": %lu, \"sent\": %lu, \"alarms\": %lu, \"samples\": %lu, \"differences\": %lu}\n",
      calls[1], calls[5], calls[6], calls[3], calls[11], differences);
  exit(differences != 0);
}

static char* next(int kind) {
  if (!fgets(text, sizeof text, record)) finish();
  ++line_number;
  char* rest;
  const long is = strtol(text, &rest, 10);
  if (is != kind) {
    fprintf(stderr, "line %lu: %d asked where the chip has %s", line_number, kind, text);
    ++differences;
    finish();
  }
  ++calls[kind];
  return rest;
}

static uint32_t number(char** rest) {
  return (uint32_t)strtoll(*rest, rest, 10);
}

static void compare(char** rest, uint32_t asked) {
  if (number(rest) == asked) return;
  ++differences;
  fprintf(stderr, "line %lu: asked %u where the chip has %s", line_number, (unsigned)asked, text);
}

static void bytes_of(const char* hex, uint8_t* to, unsigned count) {
  while (*hex == ' ') ++hex;
  for (unsigned at = 0; at < count; ++at) {
    unsigned byte = 0;
    sscanf(hex + 2 * at, "%2x", &byte);
    to[at] = (uint8_t)byte;
  }
}

static void compare_bytes(const char* hex, const uint8_t* asked, unsigned count) {
  uint8_t expected[RS_FLASH_BYTES];
  bytes_of(hex, expected, count);
  if (memcmp(expected, asked, count) == 0) return;
  ++differences;
  fprintf(stderr, "line %lu: other bytes than the chip's\n", line_number);
}

void rs_board_start(rs_boot* boot) {
  static uint8_t keys[RS_CELL_KEYS_BYTES];
  record = fopen(getenv("LOG"), "r");
  if (record == NULL) exit(2);
  char* rest = next(12);
  const char* hex = getenv("KEYS");
  boot->uid = (uint32_t)strtoul(getenv("UID_OF_CELL"), NULL, 10);
  boot->random = number(&rest);
  boot->flash = NULL;
  boot->keys = NULL;
  boot->step_us = (uint16_t)number(&rest);
  if (hex != NULL && *hex != '\0') {
    bytes_of(hex, keys, sizeof keys);
    boot->keys = keys;
  }
}

uint32_t rs_board_now_us(void) {
  char* rest = next(1);
  return number(&rest);
}

void rs_board_wanted(uint32_t wanted) {
  char* rest = next(2);
  compare(&rest, wanted);
}

void rs_board_alarms(uint32_t timer_us, bool sampling, uint32_t sample_us, uint32_t wanted) {
  char* rest = next(3);
  compare(&rest, timer_us);
  compare(&rest, sampling);
  compare(&rest, sampling ? sample_us : 0U);
  compare(&rest, wanted);
}

uint32_t rs_board_wait(void) {
  char* rest = next(4);
  return number(&rest);
}

uint32_t rs_board_receive(unsigned port, const uint8_t** bytes, bool* idle) {
  static RS_WORDS uint8_t got[RS_PORTS][32];
  char* rest = next(5);
  const uint32_t count = number(&rest);
  *idle = number(&rest) != 0U;
  bytes_of(rest, got[port], count);
  *bytes = got[port];
  return count;
}

uint32_t rs_board_late_us(unsigned port) {
  (void)port;
  char* rest = next(13);
  return number(&rest);
}

void rs_board_send(unsigned port, const uint8_t* frame) {
  char* rest = next(6);
  compare(&rest, port);
  compare_bytes(rest, frame, RS_FRAME_BYTES);
}

uint32_t rs_board_sent(void) {
  char* rest = next(7);
  return number(&rest);
}

bool rs_board_sense(rs_sample* sample) {
  char* rest = next(11);
  for (unsigned channel = 0; channel < (unsigned)RS_CHANNEL_COUNT; ++channel)
    sample->value[channel] = (int32_t)number(&rest);
  return number(&rest) != 0U;
}

void rs_board_light(uint32_t rgb) {
  char* rest = next(8);
  compare(&rest, rgb);
}

void rs_board_keep(const uint8_t* flash) {
  compare_bytes(next(9), flash, RS_FLASH_BYTES);
}

void rs_board_restart(void) {
  (void)next(10);
  finish();
}
