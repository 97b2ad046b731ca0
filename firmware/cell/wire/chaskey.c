/* SPDX-License-Identifier: Apache-2.0
 * Chaskey (Mouha et al. 2014), the message authentication code of ticks and orders. */
#include "robotskin/chaskey.h"

#include "robotskin/portable.h"

static uint32_t rotated_left(uint32_t word, unsigned by) {
  return (word << by) | (word >> (32U - by));
}

static uint32_t load_little(const uint8_t* bytes) {
  return (uint32_t)bytes[0] | ((uint32_t)bytes[1] << 8) | ((uint32_t)bytes[2] << 16) | ((uint32_t)bytes[3] << 24);
}

static void store_little(uint8_t* bytes, uint32_t word) {
  for (unsigned i = 0; i < 4U; ++i) bytes[i] = (uint8_t)(word >> (8U * i));
}

static void permute(uint32_t v[4]) {
  for (unsigned round = 0; round < 12U; ++round) {
    v[0] += v[1];
    v[1] = rotated_left(v[1], 5) ^ v[0];
    v[0] = rotated_left(v[0], 16);
    v[2] += v[3];
    v[3] = rotated_left(v[3], 8) ^ v[2];
    v[0] += v[3];
    v[3] = rotated_left(v[3], 13) ^ v[0];
    v[2] += v[1];
    v[1] = rotated_left(v[1], 7) ^ v[2];
    v[2] = rotated_left(v[2], 16);
  }
}

/* Doubling in GF(2^128) with x^128 + x^7 + x^2 + x + 1. */
static void doubled(uint32_t out[4], const uint32_t in[4]) {
  out[0] = (in[0] << 1) ^ (0x87U & (0U - (in[3] >> 31)));
  for (unsigned i = 1; i < 4U; ++i) out[i] = (in[i] << 1) | (in[i - 1U] >> 31);
}

void rs_chaskey_key_expand(rs_chaskey_key* key, const uint8_t bytes[RS_CHASKEY_KEY_BYTES]) {
  for (unsigned i = 0; i < 4U; ++i) key->word[i] = load_little(bytes + 4U * i);
  doubled(key->word + 4, key->word);
  doubled(key->word + 8, key->word + 4);
}

/* Absorbs the last block under the subkey that says whether it was padded. */
static RS_HOT void finish(const uint32_t subkey[4], const uint8_t block[RS_CHASKEY_BLOCK_BYTES], uint32_t v[4]) {
  for (unsigned i = 0; i < 4U; ++i) v[i] ^= load_little(block + 4U * i) ^ subkey[i];
  permute(v);
  for (unsigned i = 0; i < 4U; ++i) v[i] ^= subkey[i];
}

void rs_chaskey(const rs_chaskey_key* key, const uint8_t* message, uint32_t count, uint8_t tag[RS_CHASKEY_TAG_BYTES]) {
  uint32_t v[4] = {key->word[0], key->word[1], key->word[2], key->word[3]};
  while (count > RS_CHASKEY_BLOCK_BYTES) {
    for (unsigned i = 0; i < 4U; ++i) v[i] ^= load_little(message + 4U * i);
    permute(v);
    message += RS_CHASKEY_BLOCK_BYTES;
    count -= RS_CHASKEY_BLOCK_BYTES;
  }
  uint8_t last[RS_CHASKEY_BLOCK_BYTES] = {0};
  for (uint32_t i = 0; i < count; ++i) last[i] = message[i];
  const bool whole = count == RS_CHASKEY_BLOCK_BYTES;
  if (!whole) last[count] = 1;
  finish(whole ? key->word + 4 : key->word + 8, last, v);
  for (unsigned i = 0; i < 4U; ++i) store_little(tag + 4U * i, v[i]);
}

uint32_t rs_chaskey_tag32(const rs_chaskey_key* key, const uint8_t block[RS_CHASKEY_BLOCK_BYTES]) {
  uint32_t v[4] = {key->word[0], key->word[1], key->word[2], key->word[3]};
  finish(key->word + 4, block, v);
  return ((v[0] & 0xFFU) << 24) | ((v[0] & 0xFF00U) << 8) | ((v[0] >> 8) & 0xFF00U) | (v[0] >> 24);
}

bool rs_tags_equal(uint32_t a, uint32_t b) {
  const uint32_t difference = a ^ b;
  return ((difference | (0U - difference)) >> 31) == 0U;
}
