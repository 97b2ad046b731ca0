/* SPDX-License-Identifier: Apache-2.0
 * Copies of frames, a word at a time. */
#ifndef ROBOTSKIN_CELL_WIRE_FRAME_COPY_H
#define ROBOTSKIN_CELL_WIRE_FRAME_COPY_H

#include <string.h>

#include "robotskin/wire.h"

/* Copies a frame; both begin at a whole word. */
RS_INLINE void rs_frame_copy(uint8_t* to, const uint8_t* from) {
#if defined(__GNUC__)
  __builtin_memcpy(__builtin_assume_aligned(to, 4), __builtin_assume_aligned(from, 4), RS_FRAME_BYTES);
#else
  memcpy(to, from, RS_FRAME_BYTES);
#endif
}

#endif
