/* The checksum of every frame: CRC-16 with polynomial 0x15935, which keeps Hamming distance 5 at 160 bits.
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
void rs_frame_mark_replayed(uint8_t frame[RS_FRAME_BYTES]);

#ifdef __cplusplus
}
#endif

#endif
