/* SPDX-License-Identifier: Apache-2.0
 * Fields of any width in the content of a frame: 18 bytes, most significant bit first, read and written as words. */
#ifndef ROBOTSKIN_FRAME_BITS_H
#define ROBOTSKIN_FRAME_BITS_H

#include <stdint.h>

#include "robotskin/portable.h"

#ifdef __cplusplus
extern "C" {
#endif

RS_INLINE uint32_t rs_bits_get(const uint32_t* words, unsigned at, unsigned width) {
  const unsigned word = at / 32U, bit = at % 32U;
  const uint32_t mask = width == 32U ? 0xFFFFFFFFU : (1U << width) - 1U;
  if (bit + width <= 32U) return (words[word] >> (32U - bit - width)) & mask;
  const unsigned low = bit + width - 32U;
  return ((words[word] << low) | (words[word + 1U] >> (32U - low))) & mask;
}

RS_INLINE void rs_bits_put(uint32_t* words, unsigned at, unsigned width, uint32_t value) {
  const unsigned word = at / 32U, bit = at % 32U;
  if (width < 32U) value &= (1U << width) - 1U;
  if (bit + width <= 32U) {
    words[word] |= value << (32U - bit - width);
  } else {
    const unsigned low = bit + width - 32U;
    words[word] |= value >> low;
    words[word + 1U] |= value << (32U - low);
  }
}

RS_INLINE int32_t rs_sign_extend(uint32_t value, unsigned width) {
  const uint32_t sign = 1U << (width - 1U);
  return (int32_t)((value ^ sign) - sign);
}

RS_INLINE uint32_t rs_load32(const uint8_t* bytes) {
  return ((uint32_t)bytes[0] << 24) | ((uint32_t)bytes[1] << 16) | ((uint32_t)bytes[2] << 8) | (uint32_t)bytes[3];
}

RS_INLINE void rs_store32(uint8_t* bytes, uint32_t word) {
  bytes[0] = (uint8_t)(word >> 24);
  bytes[1] = (uint8_t)(word >> 16);
  bytes[2] = (uint8_t)(word >> 8);
  bytes[3] = (uint8_t)word;
}

/* One of the first four words of a frame, and back. */
RS_INLINE uint32_t rs_frame_word(const uint8_t* frame, unsigned at) {
#if defined(RS_FRAMES_AT_WORDS)
  uint32_t word; /* a little-endian processor, which turns the bytes round in one instruction */
  __builtin_memcpy(&word, RS_AT_WORD(frame + 4U * at), sizeof word);
  return __builtin_bswap32(word);
#else
  return rs_load32(frame + 4U * at);
#endif
}
RS_INLINE void rs_frame_set_word(uint8_t* frame, unsigned at, uint32_t word) {
#if defined(RS_FRAMES_AT_WORDS)
  word = __builtin_bswap32(word);
  __builtin_memcpy(RS_AT_WORD(frame + 4U * at), &word, sizeof word);
#else
  rs_store32(frame + 4U * at, word);
#endif
}

/* The content as big-endian words; the last word holds 16 content bits on top and is zero below. */
RS_INLINE void rs_content_load(uint32_t words[5], const uint8_t* bytes) {
  const uint8_t* at = (const uint8_t*)RS_AT_WORD(bytes);
  for (unsigned i = 0; i < 4U; ++i) words[i] = rs_frame_word(bytes, i);
  words[4] = ((uint32_t)at[16] << 24) | ((uint32_t)at[17] << 16);
}

RS_INLINE void rs_content_store(uint8_t* bytes, const uint32_t words[5]) {
  uint8_t* at = (uint8_t*)RS_AT_WORD(bytes);
  for (unsigned i = 0; i < 4U; ++i) rs_frame_set_word(bytes, i, words[i]);
  at[16] = (uint8_t)(words[4] >> 24);
  at[17] = (uint8_t)(words[4] >> 16);
}

#ifdef __cplusplus
}
#endif

#endif
