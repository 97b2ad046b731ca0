/* SPDX-License-Identifier: Apache-2.0
 * Finds frames in the bytes of a line: by the checksum, and by idle time before a frame where there is any.
 *
 * While aligned, every 20 bytes are a frame. A frame that fails its checksum is handed out as damaged and ends the
 * alignment: the receiver slides byte by byte until two frames in a row are right there, and hands out the second. A
 * chance hit would need two right checksums, once in four thousand million positions. */
#ifndef ROBOTSKIN_RECEIVER_H
#define ROBOTSKIN_RECEIVER_H

#include <stdbool.h>
#include <stdint.h>

#include "robotskin/wire.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
  uint8_t bytes[RS_FRAME_BYTES]; /* the last ones, a ring ending before `at` */
  uint8_t at;
  uint8_t count; /* bytes since the boundary (aligned) or in all, at most 20 (sliding) */
  bool sliding;
  uint32_t intact; /* bit k: the 20 bytes that ended k bytes ago were a frame; while sliding */
} rs_receiver;

typedef enum { RS_RECEIVED_NOTHING, RS_RECEIVED_FRAME, RS_RECEIVED_DAMAGED } rs_received;

/* A zeroed receiver is ready for the first byte of a frame. `frame` is written unless nothing is returned. */
rs_received rs_receiver_byte(rs_receiver* receiver, uint8_t byte, uint8_t frame[RS_FRAME_BYTES]);

/* The line has been idle for two byte times: the next byte starts a frame. Returns whether a frame was cut short. */
bool rs_receiver_idle(rs_receiver* receiver);

/* Whether the next byte starts a frame. */
RS_INLINE bool rs_receiver_at_boundary(const rs_receiver* receiver) {
  return receiver->count == 0U && !receiver->sliding;
}

#ifdef __cplusplus
}
#endif

#endif
