/* SPDX-License-Identifier: Apache-2.0
 * Frames out of a stream of bytes (see receiver.h). */
#include "robotskin/receiver.h"

#include "robotskin/crc.h"

/* Copies the ring, oldest byte first. */
static void copy_out(const rs_receiver* receiver, uint8_t frame[RS_FRAME_BYTES]) {
  for (unsigned i = 0; i < RS_FRAME_BYTES; ++i) frame[i] = receiver->bytes[(receiver->at + i) % RS_FRAME_BYTES];
}

rs_received rs_receiver_byte(rs_receiver* receiver, uint8_t byte, uint8_t frame[RS_FRAME_BYTES]) {
  receiver->bytes[receiver->at % RS_FRAME_BYTES] = byte;
  receiver->at = (uint8_t)((receiver->at + 1U) % RS_FRAME_BYTES);
  if (receiver->count < RS_FRAME_BYTES) ++receiver->count;
  receiver->intact <<= 1;
  if (receiver->count < RS_FRAME_BYTES) return RS_RECEIVED_NOTHING;

  copy_out(receiver, frame);
  const bool intact = rs_frame_intact(frame);
  if (!receiver->sliding) {
    if (intact) {
      receiver->count = 0;
      return RS_RECEIVED_FRAME;
    }
    receiver->sliding = true;
    receiver->intact = 0;
    return RS_RECEIVED_DAMAGED;
  }
  if (!intact) return RS_RECEIVED_NOTHING;
  receiver->intact |= 1U;
  if ((receiver->intact >> RS_FRAME_BYTES & 1U) == 0U) return RS_RECEIVED_NOTHING;
  receiver->sliding = false;
  receiver->count = 0;
  return RS_RECEIVED_FRAME;
}

bool rs_receiver_idle(rs_receiver* receiver) {
  const bool cut_short = !receiver->sliding && receiver->count > 0U;
  receiver->count = 0;
  receiver->sliding = false;
  return cut_short;
}
