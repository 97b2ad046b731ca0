/* SPDX-License-Identifier: Apache-2.0
 * The checksum of every frame: CRC-16 with polynomial 0x15935, which keeps Hamming distance 5 at 160 bits.
 *
 * (The well-known DNP polynomial 0x3D65 has distance 6 up to 144 bits, but only 2 at 160.) Most significant bit first,
 * started with 0xFFFF so that a silent line of zeros is no frame. The checksum stands big-endian in bytes 18 and 19. */
#ifndef ROBOTSKIN_CRC_H
#define ROBOTSKIN_CRC_H

#include <stdbool.h>
#include <stdint.h>

#include "robotskin/wire.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { RS_CRC_POLYNOMIAL = 0x15935, RS_CRC_START = 0xFFFF };

/* Checksum of `count` bytes. */
uint16_t rs_crc16(const uint8_t* bytes, uint32_t count);

/* Writes the checksum of a frame's 18 content bytes behind them. */
void rs_frame_seal(uint8_t frame[RS_FRAME_BYTES]);

/* Whether a frame's checksum is right. */
bool rs_frame_intact(const uint8_t frame[RS_FRAME_BYTES]);

/* Takes one hop off the frame's time to live and adjusts the checksum; false, and the frame unchanged, if none is left
 * or the frame's type has no time to live. */
bool rs_frame_take_hop(uint8_t frame[RS_FRAME_BYTES]);

/* Says of a sample that it is sent again; the checksum follows likewise. */
void rs_frame_mark_retransmitted(uint8_t frame[RS_FRAME_BYTES]);
RS_INLINE bool rs_frame_is_retransmitted(const uint8_t frame[RS_FRAME_BYTES]) {
  return (frame[RS_clock_retransmitted_AT / 8] >> (7U - RS_clock_retransmitted_AT % 8) & 1U) != 0U;
}

/* What a hop taken changes in a sample's checksum, by the hops left before: it is linear, and the time to live is the
 * lower part of byte 3. Byte 18 is the lower half. */
extern const uint16_t rs_sample_hop_change[64];
RS_STATIC_ASSERT((int)RS_clock_ttl_AT == 26 && (int)RS_clock_ttl_LAST == 31 && (int)RS_event_ttl_AT == 26 &&
                     (int)RS_further_ttl_AT == 26,
                 "hops left are the lower six bits of byte 3");

/* What a tick's fields of a link change in the checksum of one that has 0 in them: by sender_port << 2 | parent << 1 |
 * heard, and by echo. The two are to be added (XOR), in the byte order of rs_sample_hop_change. */
extern const uint16_t rs_tick_link_change[16];
extern const uint16_t rs_tick_ack_change[256];

/* Adds such a change to a frame's checksum. */
RS_INLINE void rs_frame_change_checksum(uint8_t frame[RS_FRAME_BYTES], uint32_t change) {
#if defined(RS_FRAMES_AT_WORDS)
  uint8_t* at = (uint8_t*)RS_AT_WORD(frame) + RS_CONTENT_BYTES;
  uint16_t checksum;
  __builtin_memcpy(&checksum, at, sizeof checksum);
  checksum ^= (uint16_t)change;
  __builtin_memcpy(at, &checksum, sizeof checksum);
#else
  frame[RS_CONTENT_BYTES] ^= (uint8_t)change;
  frame[RS_CONTENT_BYTES + 1] ^= (uint8_t)(change >> 8);
#endif
}

/* Whether a clock or event frame has a hop left, and rs_frame_take_hop of one that has. */
RS_INLINE bool rs_sample_has_hop(const uint8_t frame[RS_FRAME_BYTES]) {
  return (frame[3] & 0x3FU) != 0U;
}
RS_INLINE void rs_sample_take_hop(uint8_t frame[RS_FRAME_BYTES]) {
  const uint32_t change = rs_sample_hop_change[frame[3] & 0x3FU];
  --frame[3];
  rs_frame_change_checksum(frame, change);
}

/* Copies such a frame, a hop less. */
RS_INLINE void rs_sample_bring(uint8_t to[RS_FRAME_BYTES], const uint8_t from[RS_FRAME_BYTES]) {
#if defined(RS_FRAMES_AT_WORDS)
  uint32_t words[RS_FRAME_BYTES / 4];
  __builtin_memcpy(words, RS_AT_WORD(from), sizeof words);
  words[4] ^= (uint32_t)rs_sample_hop_change[words[0] >> 24 & 0x3FU] << 16;
  words[0] -= 1U << 24;
  __builtin_memcpy(RS_AT_WORD(to), words, sizeof words);
#else
  __builtin_memcpy(to, from, RS_FRAME_BYTES);
  rs_sample_take_hop(to);
#endif
}

#ifdef __cplusplus
}
#endif

#endif
