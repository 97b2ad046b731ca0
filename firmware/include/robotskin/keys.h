/* SPDX-License-Identifier: Apache-2.0
 * The keys of a cell, derived from the secret that the section units of a group share.
 *
 * What is for all cells has a tag under the group's key, what is for one under that cell's own. A cell is made with
 * both and never holds the secret: one that is opened tells nothing of another's own key. */
#ifndef ROBOTSKIN_KEYS_H
#define ROBOTSKIN_KEYS_H

#include "robotskin/chaskey.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
  RS_CELL_KEY_BYTES = RS_CHASKEY_KEY_BYTES, /* the secret, and each key that comes from it */
  RS_CELL_KEYS_BYTES = 2 * RS_CELL_KEY_BYTES,
  RS_TURN_LOW_BITS = 14,  /* of a turn in a naming command: these stand in `target`, the others in `spare` */
  RS_TURN_MASK = 0x3FFFFF /* 8900 years */
};

#define RS_TURN_NONE UINT32_MAX

/* A turn is as long as the ticks count, 2^26 ms or 18.6 hours. What is for one turn has a tag under a key of that turn,
 * so no time comes round under one key. */
void rs_key_of_turn(const uint8_t key[RS_CELL_KEY_BYTES], uint32_t turn, uint8_t of_turn[RS_CELL_KEY_BYTES]);

/* The keys that the cell with serial number `uid` is made with: the group's, then its own. */
void rs_cell_keys(const uint8_t secret[RS_CELL_KEY_BYTES], uint32_t uid, uint8_t keys[RS_CELL_KEYS_BYTES]);

#ifdef __cplusplus
}
#endif

#endif
