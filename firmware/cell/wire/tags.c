/* SPDX-License-Identifier: Apache-2.0
 * Tags of the frames that only a section unit may make: what they cover, and of which time they are. */
#include "cell/wire/tags.h"

#include "cell/wire/wave.h"

uint32_t rs_wave_tag(const rs_chaskey_key* key, const rs_wave* wave) {
  const uint8_t block[RS_CHASKEY_BLOCK_BYTES] = {(uint8_t)(RS_TYPE_tick << 4),
                                                 (uint8_t)(wave->era >> 8),
                                                 (uint8_t)wave->era,
                                                 (uint8_t)(wave->sequence >> 8),
                                                 (uint8_t)wave->sequence,
                                                 wave->root,
                                                 wave->forming,
                                                 wave->depth_cap,
                                                 wave->rate_divisor,
                                                 wave->gain_threshold};
  return rs_chaskey_tag32(key, block);
}

uint32_t rs_command_tag(const uint8_t key[RS_CELL_KEY_BYTES], const uint8_t frame[RS_FRAME_BYTES], uint32_t time) {
  enum { COVERED = RS_command_tag_AT / 8 };
  RS_STATIC_ASSERT(COVERED + 2 == RS_CHASKEY_BLOCK_BYTES, "a command and its second fill one block");
  const uint32_t second = (time & ((1U << RS_TICK_TIME_BITS) - 1U)) >> RS_TAG_SECOND_BITS;
  uint8_t block[RS_CHASKEY_BLOCK_BYTES];
  for (unsigned i = 0; i < COVERED; ++i) block[i] = frame[i];
  block[COVERED] = (uint8_t)(second >> 8);
  block[COVERED + 1] = (uint8_t)second;
  rs_chaskey_key expanded;
  rs_chaskey_key_expand(&expanded, key);
  return rs_chaskey_tag32(&expanded, block);
}

uint32_t rs_joints_tag(const uint8_t key[RS_CELL_KEY_BYTES], const uint8_t frame[RS_FRAME_BYTES], uint32_t epoch) {
  enum { COVERED = RS_joints_tag_AT / 8 };
  uint8_t message[COVERED + 3];
  uint8_t tag[RS_CHASKEY_TAG_BYTES];
  for (unsigned i = 0; i < COVERED; ++i) message[i] = frame[i];
  const uint32_t high = (epoch & ((1U << RS_TICK_TIME_BITS) / RS_EPOCH_TICKS - 1U)) / (RS_EPOCH_MASK + 1U);
  message[COVERED] = (uint8_t)(high >> 16);
  message[COVERED + 1] = (uint8_t)(high >> 8);
  message[COVERED + 2] = (uint8_t)high;
  rs_chaskey_key expanded;
  rs_chaskey_key_expand(&expanded, key);
  rs_chaskey(&expanded, message, sizeof message, tag);
  return rs_load32(tag);
}
