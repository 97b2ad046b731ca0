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
// clang-format on
#define BIT(i, k, s) ((((i) >> (k)) & 1) != 0 ? (s) : 0)
#define ENTRY(i, a, b, c, d, e, f, g, h)                                                                              \
  (uint16_t)(BIT(i, 0, a) ^ BIT(i, 1, b) ^ BIT(i, 2, c) ^ BIT(i, 3, d) ^ BIT(i, 4, e) ^ BIT(i, 5, f) ^ BIT(i, 6, g) ^ \
             BIT(i, 7, h))
#define ROW_4(i, ...) \
  ENTRY((i), __VA_ARGS__), ENTRY((i) + 1, __VA_ARGS__), ENTRY((i) + 2, __VA_ARGS__), ENTRY((i) + 3, __VA_ARGS__)
#define ROW_16(i, ...) \
  ROW_4((i), __VA_ARGS__), ROW_4((i) + 4, __VA_ARGS__), ROW_4((i) + 8, __VA_ARGS__), ROW_4((i) + 12, __VA_ARGS__)
#define ROW_64(i, ...) \
  ROW_16((i), __VA_ARGS__), ROW_16((i) + 16, __VA_ARGS__), ROW_16((i) + 32, __VA_ARGS__), ROW_16((i) + 48, __VA_ARGS__)
#define TABLE(...) {ROW_64(0, __VA_ARGS__), ROW_64(64, __VA_ARGS__), ROW_64(128, __VA_ARGS__), ROW_64(192, __VA_ARGS__)}

/* contribution[k][b]: of byte b when k bytes follow it. */
static const uint16_t contribution[4][256] = {
    TABLE(S0, S1, S2, S3, S4, S5, S6, S7), TABLE(S8, S9, S10, S11, S12, S13, S14, S15),
    TABLE(S16, S17, S18, S19, S20, S21, S22, S23), TABLE(S24, S25, S26, S27, S28, S29, S30, S31)};

uint16_t rs_crc16(const uint8_t* bytes, uint32_t count) {
  uint32_t crc = RS_CRC_START;
  for (; count >= 4U; count -= 4U, bytes += 4) {
    crc = (uint32_t)contribution[3][bytes[0] ^ (crc >> 8)] ^ contribution[2][bytes[1] ^ (crc & 0xFFU)] ^
          contribution[1][bytes[2]] ^ contribution[0][bytes[3]];
  }
  for (; count > 0U; --count, ++bytes) crc = ((crc << 8) & 0xFFFFU) ^ contribution[0][(crc >> 8) ^ *bytes];
  return (uint16_t)crc;
}

void rs_frame_seal(uint8_t frame[RS_FRAME_BYTES]) {
  const uint16_t crc = rs_crc16(frame, RS_CONTENT_BYTES);
  frame[RS_CONTENT_BYTES] = (uint8_t)(crc >> 8);
  frame[RS_CONTENT_BYTES + 1] = (uint8_t)crc;
}

bool rs_frame_intact(const uint8_t frame[RS_FRAME_BYTES]) {
  return rs_crc16(frame, RS_CONTENT_BYTES) == (((uint32_t)frame[RS_CONTENT_BYTES] << 8) | frame[RS_CONTENT_BYTES + 1]);
}

/* Position of the first bit of a frame's time to live; 0 for a type that has none. */
static unsigned ttl_position(rs_frame_type type) {
  switch (type) {
    case RS_TYPE_clock:
      return RS_clock_ttl_AT;
    case RS_TYPE_event:
      return RS_event_ttl_AT;
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
  for (; count >= 4U; count -= 4U) crc = (uint32_t)contribution[3][crc >> 8] ^ contribution[2][crc & 0xFFU];
  for (; count > 0U; --count) crc = ((crc << 8) & 0xFFFFU) ^ contribution[0][crc >> 8];
  return crc;
}

/* Changes bits of two bytes. A checksum is linear: what changes in it is the checksum, started with 0, of what changes
 * in the frame; so one that was wrong stays so. */
static void change(uint8_t frame[RS_FRAME_BYTES], unsigned byte, uint32_t changed) {
  frame[byte] ^= (uint8_t)(changed >> 8);
  frame[byte + 1U] ^= (uint8_t)changed;
  const uint32_t difference = past_zeros((uint32_t)contribution[1][changed >> 8] ^ contribution[0][changed & 0xFFU],
                                         RS_CONTENT_BYTES - 2U - byte);
  frame[RS_CONTENT_BYTES] ^= (uint8_t)(difference >> 8);
  frame[RS_CONTENT_BYTES + 1] ^= (uint8_t)difference;
}

void rs_frame_mark_replayed(uint8_t frame[RS_FRAME_BYTES]) {
  RS_STATIC_ASSERT((int)RS_clock_replayed_AT == (int)RS_event_replayed_AT, "samples are laid out alike");
  const unsigned byte = RS_clock_replayed_AT / 8;
  const uint32_t bit = 0x8000U >> RS_clock_replayed_AT % 8;
  if ((((uint32_t)frame[byte] << 8) & bit) == 0U) change(frame, byte, bit);
}

bool rs_frame_take_hop(uint8_t frame[RS_FRAME_BYTES]) {
  const unsigned at = ttl_position(rs_frame_type_of(frame));
  if (at == 0U) return false;
  /* The field's six bits lie in at most two bytes. */
  const unsigned byte = at / 8U, shift = 10U - at % 8U;
  const uint32_t before = ((uint32_t)frame[byte] << 8) | frame[byte + 1U];
  if (((before >> shift) & 0x3FU) == 0U) return false;
  change(frame, byte, before ^ (before - (1U << shift)));
  return true;
}
