/* SPDX-License-Identifier: Apache-2.0
 * Rings of frames: what queues.c fills and transmit.c empties. Every index is masked, so that no corrupted count leaves
 * the arrays; sizes are powers of two. */
#ifndef ROBOTSKIN_CELL_TRANSPORT_RINGS_H
#define ROBOTSKIN_CELL_TRANSPORT_RINGS_H

#include <stddef.h>

#include "cell/wire/frame_copy.h"
#include "robotskin/cell.h"

/* The place of one more frame, for which there must be room. */
RS_INLINE uint8_t* rs_ring_place(rs_ring* ring, uint8_t (*frames)[RS_FRAME_BYTES], unsigned size) {
  return frames[(ring->first + ring->count++) & (size - 1U)];
}

/* The same; NULL if there is none. */
RS_INLINE uint8_t* rs_ring_append(rs_ring* ring, uint8_t (*frames)[RS_FRAME_BYTES], unsigned size) {
  return ring->count < size ? rs_ring_place(ring, frames, size) : NULL;
}

/* Copies the oldest frame out, which then is gone; false if there is none. */
RS_INLINE bool rs_ring_take(rs_ring* ring, uint8_t (*frames)[RS_FRAME_BYTES], unsigned size, uint8_t* frame) {
  if (ring->count == 0U) return false;
  rs_frame_copy(frame, frames[ring->first & (size - 1U)]);
  ring->first = (uint8_t)((ring->first + 1U) & (size - 1U));
  --ring->count;
  return true;
}

/* The samples sent lately stay in the ring, as far as those that wait leave room. */
RS_INLINE void rs_samples_sent_within(rs_queues* queues) {
  const unsigned room = (unsigned)RS_QUEUE_DATA - queues->data.count;
  if (queues->data_sent > room) queues->data_sent = (uint8_t)room;
}

/* The oldest frames that no port waits for any more make room. */
RS_INLINE void rs_down_let_go(rs_queues* queues) {
  while (queues->down.count > 0U && queues->down_ports[queues->down.first & (RS_QUEUE_DOWN - 1U)] == 0U) {
    queues->down.first = (uint8_t)((queues->down.first + 1U) & (RS_QUEUE_DOWN - 1U));
    --queues->down.count;
  }
}

/* Where the next frame of a port is put together; which becomes its last one. */
RS_INLINE uint8_t* rs_sending_next(rs_queues* queues, unsigned port) {
  return queues->sending[port][(queues->sending_last[port] + 1U) & (RS_FRAMES_OUT - 1U)];
}
RS_INLINE void rs_sending_turn(rs_queues* queues, unsigned port) {
  ++queues->sending_last[port];
}
RS_INLINE const uint8_t* rs_sending_last(const rs_queues* queues, unsigned port) {
  return queues->sending[port][queues->sending_last[port] & (RS_FRAMES_OUT - 1U)];
}

/* Takes the oldest sample, of which there must be one, and keeps it for a while. */
RS_INLINE void rs_samples_take(rs_queues* queues, uint32_t now_us, uint8_t* frame) {
  rs_ring_take(&queues->data, queues->data_frame, RS_QUEUE_DATA, frame);
  if (now_us - queues->data_sent_us > RS_REPEAT_MOST_US) queues->data_sent = 0;
  queues->data_sent_us = now_us;
  ++queues->data_sent;
}

#endif
