/* SPDX-License-Identifier: Apache-2.0
 * The checksum of a frame, and what small changes of a frame change in it. */
#include "robotskin/crc.h"

/* Sk is x^(16 + k) modulo the polynomial: what a single bit contributes when k bits follow it. The tables that treat
 * four bytes at once are sums of these, so the polynomial stands in one place. */
#define STEP(s) ((((s) << 1) ^ ((((s) >> 15) & 1) != 0 ? RS_CRC_POLYNOMIAL : 0)) & 0xFFFF)
// clang-format off
enum {
  S0 = RS_CRC_POLYNOMIAL & 0xFFFF,
  S1 = STEP(S0), S2 = STEP(S1), S3 = STEP(S2), S4 = STEP(S3), S5 = STEP(S4),
  S6 = STEP(S5), S7 = STEP(S6), S8 = STEP(S7), S9 = STEP(S8), S10 = STEP(S9),
  S11 = STEP(S10), S12 = STEP(S11), S13 = STEP(S12), S14 = STEP(S13), S15 = STEP(S14),
  S16 = STEP(S15), S17 = STEP(S16), S18 = STEP(S17), S19 = STEP(S18), S20 = STEP(S19),
  S21 = STEP(S20), S22 = STEP(S21), S23 = STEP(S22), S24 = STEP(S23), S25 = STEP(S24),
  S26 = STEP(S25), S27 = STEP(S26), S28 = STEP(S27), S29 = STEP(S28), S30 = STEP(S29),
  S31 = STEP(S30)
};
/* T0 to T5: of the lowest bits of byte 3, behind which 14 more follow; U counts on from S31, a byte a line. */
#define NEXT_BYTE(to, from)                                                                                    \
  to##_1 = STEP(from), to##_2 = STEP(to##_1), to##_3 = STEP(to##_2), to##_4 = STEP(to##_3), to##_5 = STEP(to##_4), \
  to##_6 = STEP(to##_5), to##_7 = STEP(to##_6), to = STEP(to##_7)
enum {
  NEXT_BYTE(U5, S31), NEXT_BYTE(U6, U5), NEXT_BYTE(U7, U6), NEXT_BYTE(U8, U7), NEXT_BYTE(U9, U8),
  NEXT_BYTE(U10, U9), NEXT_BYTE(U11, U10), NEXT_BYTE(U12, U11), NEXT_BYTE(U13, U12), NEXT_BYTE(U14, U13),
  T0 = STEP(U14), T1 = STEP(T0), T2 = STEP(T1), T3 = STEP(T2), T4 = STEP(T3), T5 = STEP(T4)
};
// clang-format on
#define BIT(i, k, s) ((((i) >> (k)) & 1) != 0 ? (s) : 0)
#define SWAPPED(s) (uint16_t)(((s) >> 8 | (s) << 8) & 0xFFFF)
#define ENTRY(i, a, b, c, d, e, f, g, h)                                                                           \
  SWAPPED(BIT(i, 0, a) ^ BIT(i, 1, b) ^ BIT(i, 2, c) ^ BIT(i, 3, d) ^ BIT(i, 4, e) ^ BIT(i, 5, f) ^ BIT(i, 6, g) ^ \
          BIT(i, 7, h))
#define ROW_4(i, ...) \
  ENTRY((i), __VA_ARGS__), ENTRY((i) + 1, __VA_ARGS__), ENTRY((i) + 2, __VA_ARGS__), ENTRY((i) + 3, __VA_ARGS__)
#define ROW_16(i, ...) \
  ROW_4((i), __VA_ARGS__), ROW_4((i) + 4, __VA_ARGS__), ROW_4((i) + 8, __VA_ARGS__), ROW_4((i) + 12, __VA_ARGS__)
#define ROW_64(i, ...) \
  ROW_16((i), __VA_ARGS__), ROW_16((i) + 16, __VA_ARGS__), ROW_16((i) + 32, __VA_ARGS__), ROW_16((i) + 48, __VA_ARGS__)
#define TABLE(...) {ROW_64(0, __VA_ARGS__), ROW_64(64, __VA_ARGS__), ROW_64(128, __VA_ARGS__), ROW_64(192, __VA_ARGS__)}

/* contribution[k][b]: of byte b when k bytes follow it, its upper byte first in memory, as checksums stand in frames.
 */
static const uint16_t contribution[][256] = {
    TABLE(S0, S1, S2, S3, S4, S5, S6, S7),
    TABLE(S8, S9, S10, S11, S12, S13, S14, S15),
#if !defined(RS_FRAMES_AT_WORDS)
    TABLE(S16, S17, S18, S19, S20, S21, S22, S23),
    TABLE(S24, S25, S26, S27, S28, S29, S30, S31),
#endif
};

/* A hop taken from `ttl` left changes the bits of ttl ^ (ttl - 1); at 0 nothing is taken. */
#define HOP(ttl) ENTRY((ttl) ^ ((ttl) + 63), T0, T1, T2, T3, T4, T5, 0, 0)
#define HOPS_4(ttl) HOP(ttl), HOP((ttl) + 1), HOP((ttl) + 2), HOP((ttl) + 3)
#define HOPS_16(ttl) HOPS_4(ttl), HOPS_4((ttl) + 4), HOPS_4((ttl) + 8), HOPS_4((ttl) + 12)
const uint16_t rs_sample_hop_change[64] = {HOPS_16(0), HOPS_16(16), HOPS_16(32), HOPS_16(48)};

/* What is another at each port in a tick. A bit that k others follow counts Sk; U5 is S39, U6 is S47 and so on. */
RS_STATIC_ASSERT((int)RS_tick_sender_port_LAST == RS_CONTENT_BITS - 1 - 92 && (int)RS_tick_sender_port_AT == 50,
                 "U12_5 is the last bit of the port");
RS_STATIC_ASSERT((int)RS_tick_heard_AT == RS_CONTENT_BITS - 1 - 82 && (int)RS_tick_parent_AT == 60,
                 "U11_3 is the bit that tells a neighbour that it is heard");
RS_STATIC_ASSERT((int)RS_tick_ack_LAST == RS_CONTENT_BITS - 1 - 54 && (int)RS_tick_ack_AT == 82,
                 "U7_7 is the last bit of the echo");
#define LINK_4(i) LINK(i), LINK((i) + 1), LINK((i) + 2), LINK((i) + 3)
#define LINK(i) ENTRY((i), U11_3, U11_4, U12_5, U12_6, 0, 0, 0, 0)
const uint16_t rs_tick_link_change[16] = {LINK_4(0), LINK_4(4), LINK_4(8), LINK_4(12)};
const uint16_t rs_tick_ack_change[256] = TABLE(U7_7, U7, U8_1, U8_2, U8_3, U8_4, U8_5, U8_6);

/* The checksums below have their two bytes swapped, so that the next bytes of a little-endian word meet theirs. */
static uint32_t load_little(const uint8_t* bytes) {
  return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

static uint32_t after_byte(uint32_t crc, uint32_t byte) {
  return crc >> 8 ^ contribution[0][(crc ^ byte) & 0xFFU];
}

static uint32_t after_half(uint32_t crc, uint32_t half) {
  half ^= crc;
  return (uint32_t)contribution[1][half & 0xFFU] ^ contribution[0][half >> 8];
}

static uint32_t after_word(uint32_t crc, uint32_t word) {
#if defined(RS_FRAMES_AT_WORDS)
  return after_half(after_half(crc, word & 0xFFFFU), word >> 16); /* two tables leave a small processor registers */
#else
  word ^= crc;
  return (uint32_t)contribution[3][word & 0xFFU] ^ contribution[2][word >> 8 & 0xFFU] ^
         contribution[1][word >> 16 & 0xFFU] ^ contribution[0][word >> 24];
#endif
}

uint16_t rs_crc16(const uint8_t* bytes, uint32_t count) {
  uint32_t crc = RS_CRC_START;
  for (; count >= 4U; count -= 4U, bytes += 4) crc = after_word(crc, load_little(bytes));
  for (; count > 0U; --count, ++bytes) crc = after_byte(crc, *bytes);
  return SWAPPED(crc);
}

/* Of the content of a frame, XORed with the checksum behind it. */
RS_INLINE uint32_t of_frame(const uint8_t* frame) {
  const uint8_t* at = (const uint8_t*)RS_AT_WORD(frame);
  uint32_t crc = RS_CRC_START;
  for (unsigned i = 0; i < RS_CONTENT_BYTES / 4U; ++i) crc = after_word(crc, load_little(at + 4U * i));
  const uint32_t last = load_little(at + RS_CONTENT_BYTES - 2);
  return after_half(crc, last & 0xFFFFU) ^ last >> 16;
}

void rs_frame_seal(uint8_t frame[RS_FRAME_BYTES]) {
  frame[RS_CONTENT_BYTES] = frame[RS_CONTENT_BYTES + 1] = 0;
  const uint32_t crc = of_frame(frame);
  frame[RS_CONTENT_BYTES] = (uint8_t)crc;
  frame[RS_CONTENT_BYTES + 1] = (uint8_t)(crc >> 8);
}

bool rs_frame_intact(const uint8_t frame[RS_FRAME_BYTES]) {
  return of_frame(frame) == 0U;
}

/* Position of the first bit of the time to live of a frame that is no sample; 0 for a type that has none. */
static unsigned ttl_position(rs_frame_type type) {
  switch (type) {
    case RS_TYPE_topology:
      return RS_topology_ttl_AT;
    case RS_TYPE_reply:
      return RS_reply_ttl_AT;
    case RS_TYPE_join:
      return RS_join_ttl_AT;
    default:
      return 0;
  }
}

/* Steps a checksum on over `count` zero bytes. */
static uint32_t past_zeros(uint32_t crc, unsigned count) {
  for (; count >= 4U; count -= 4U) crc = after_word(crc, 0);
  for (; count > 0U; --count) crc = after_byte(crc, 0);
  return crc;
}

/* Changes bits of two bytes. A checksum is linear: what changes in it is the checksum, started with 0, of what changes
 * in the frame; so one that was wrong stays so. */
static void change(uint8_t frame[RS_FRAME_BYTES], unsigned byte, uint32_t changed) {
  frame[byte] ^= (uint8_t)(changed >> 8);
  frame[byte + 1U] ^= (uint8_t)changed;
  const uint32_t difference = past_zeros((uint32_t)contribution[1][changed >> 8] ^ contribution[0][changed & 0xFFU],
                                         RS_CONTENT_BYTES - 2U - byte);
  frame[RS_CONTENT_BYTES] ^= (uint8_t)difference;
  frame[RS_CONTENT_BYTES + 1] ^= (uint8_t)(difference >> 8);
}

void rs_frame_mark_retransmitted(uint8_t frame[RS_FRAME_BYTES]) {
  RS_STATIC_ASSERT((int)RS_clock_retransmitted_AT == (int)RS_event_retransmitted_AT &&
                       (int)RS_clock_retransmitted_AT == (int)RS_further_retransmitted_AT,
                   "samples are laid out alike");
  const unsigned byte = RS_clock_retransmitted_AT / 8;
  const uint32_t bit = 0x8000U >> RS_clock_retransmitted_AT % 8;
  if ((((uint32_t)frame[byte] << 8) & bit) == 0U) change(frame, byte, bit);
}

bool rs_frame_take_hop(uint8_t frame[RS_FRAME_BYTES]) {
  const rs_frame_type type = rs_frame_type_of(frame);
  if (type == RS_TYPE_clock || type == RS_TYPE_event || type == RS_TYPE_further) {
    if (!rs_sample_has_hop(frame)) return false;
    rs_sample_take_hop(frame);
    return true;
  }
  const unsigned at = ttl_position(type);
  if (at == 0U) return false;
  /* The field's six bits lie in at most two bytes. */
  const unsigned byte = at / 8U, shift = 10U - at % 8U;
  const uint32_t before = ((uint32_t)frame[byte] << 8) | frame[byte + 1U];
  if (((before >> shift) & 0x3FU) == 0U) return false;
  change(frame, byte, before ^ (before - (1U << shift)));
  return true;
}
