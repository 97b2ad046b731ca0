/* SPDX-License-Identifier: Apache-2.0
 * Keys from the secret: tags of Chaskey-12, of which none can be told from another or from chance. */
#include "robotskin/keys.h"

#include "robotskin/portable.h"

enum { OF_GROUP = 1, OF_CELL = 2, OF_TURN = 3 }; /* first byte of what makes a key */

void rs_cell_keys(const uint8_t secret[RS_CELL_KEY_BYTES], uint32_t uid, uint8_t keys[RS_CELL_KEYS_BYTES]) {
  RS_STATIC_ASSERT((int)RS_CHASKEY_TAG_BYTES == (int)RS_CELL_KEY_BYTES, "a tag is a key");
  rs_chaskey_key expanded;
  rs_chaskey_key_expand(&expanded, secret);
  const uint8_t of_group = OF_GROUP;
  rs_chaskey(&expanded, &of_group, 1, keys);
  const uint8_t of_cell[5] = {OF_CELL, (uint8_t)(uid >> 24), (uint8_t)(uid >> 16), (uint8_t)(uid >> 8), (uint8_t)uid};
  rs_chaskey(&expanded, of_cell, sizeof of_cell, keys + RS_CELL_KEY_BYTES);
}

void rs_key_of_turn(const uint8_t key[RS_CELL_KEY_BYTES], uint32_t turn, uint8_t of_turn[RS_CELL_KEY_BYTES]) {
  rs_chaskey_key expanded;
  rs_chaskey_key_expand(&expanded, key);
  const uint8_t message[5] = {OF_TURN, (uint8_t)(turn >> 24), (uint8_t)(turn >> 16), (uint8_t)(turn >> 8),
                              (uint8_t)turn};
  rs_chaskey(&expanded, message, sizeof message, of_turn);
}
