/* SPDX-License-Identifier: Apache-2.0
 * How a cell without keys gets them, once: over the cable, from a program that is alone with it on the line.
 *
 * A cell in this state takes part in no network. It answers key frames (wire.h), and is silent otherwise. The group's
 * key and its own come in a frame each; a third one asks it to keep both, with a check sum under the key that has just
 * come: a mixture of two attempts, or the keys of another cell, are never kept. From then on it refuses any others, and
 * as a cell that runs it reads no key frame at all. */
#ifndef ROBOTSKIN_COMMISSIONING_H
#define ROBOTSKIN_COMMISSIONING_H

#include <stdbool.h>
#include <stdint.h>

#include "robotskin/keys.h"
#include "robotskin/wire.h"

#ifdef __cplusplus
extern "C" {
#endif

/* X(name, number, meaning): the `step` of a key frame */
#define RS_KEY_STEPS(X)                                                                     \
  X(ask, 1, "host: which cell is there?")                                                   \
  X(factory, 2, "cell: it has no keys; its serial number, the version of its firmware")     \
  X(group, 3, "host: the group's key")                                                      \
  X(own, 4, "host: the cell's own key")                                                     \
  X(keep, 5, "host: keep both; the cell's serial number, the check of both")                \
  X(kept, 6, "cell: they are in its memory for good; its serial number, the check of both") \
  X(refused, 7, "cell: another cell's, a check that is wrong, or it has kept others; its serial number")

#define RS_KEY_STEP_NUMBER(name, number, text) RS_KEY_##name = (number),
enum { RS_KEY_STEPS(RS_KEY_STEP_NUMBER) RS_KEY_STEP_LIMIT = 16 };
#undef RS_KEY_STEP_NUMBER

enum { RS_COMMISSIONED_US = 200000 }; /* a cell that has kept its keys runs when so long nothing was said to it */

/* Zeroed: nothing has come. */
typedef struct {
  uint8_t keys[RS_CELL_KEYS_BYTES];
  uint8_t come; /* bit 0: the group's, bit 1: its own */
  uint8_t kept;
} rs_commissioning;

typedef enum {
  RS_COMMISSIONING_NOTHING,
  RS_COMMISSIONING_ANSWER, /* send `answer` */
  RS_COMMISSIONING_KEEP    /* write `keys` where the next boot finds them, then send `answer` */
} rs_commissioning_do;

/* What the cell with serial number `uid` does with a frame whose checksum is right. */
rs_commissioning_do rs_commissioning_frame(rs_commissioning* cell, uint32_t uid, const uint8_t frame[RS_FRAME_BYTES],
                                           uint8_t answer[RS_FRAME_BYTES]);

/* A key frame with 16 bytes of a key, or with two words. */
void rs_key_frame_of_key(uint8_t frame[RS_FRAME_BYTES], uint32_t step, const uint8_t key[RS_CELL_KEY_BYTES]);
void rs_key_frame_of_words(uint8_t frame[RS_FRAME_BYTES], uint32_t step, uint32_t first, uint32_t second);

/* The check in `keep` and in `kept`: under the cell's own key, of the group's, the serial number and the step. */
uint32_t rs_key_check(const uint8_t keys[RS_CELL_KEYS_BYTES], uint32_t uid, uint32_t step);

#ifdef __cplusplus
}
#endif

#endif
