/* SPDX-License-Identifier: Apache-2.0
 * What the upper end of a link has heard of the frames that must not be lost: events and torque sums.
 *
 * Such frames carry no number of the link. Both ends count them instead, modulo 128: the lower end says in each of its
 * ticks the number that the next one will have (`ack`), the upper end compares it with what it has counted. As a wire
 * keeps the order, a number that agrees confirms all before it. The upper end answers in its own ticks with the last
 * number that agreed and, in the top bit, whether frames have been missed since; it then goes on missing until the
 * lower end goes back to that number and sends again from there (go-back-N, see arq_sender.h). */
#ifndef ROBOTSKIN_ARQ_RECEIVER_H
#define ROBOTSKIN_ARQ_RECEIVER_H

#include <stdbool.h>
#include <stdint.h>

#include "robotskin/portable.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
  RS_NUMBER_MASK = 0x7F,
  RS_ARQ_MISSED = 0x80,
  RS_SERIAL_MASK = 0x1F,      /* serials of torque frames */
  RS_SERIALS_REMEMBERED = 16, /* at most half of the serials */
  RS_SERIALS_KEPT_EPOCHS = 3  /* longer than a torque frame is sent again for, RS_TORQUE_RETRY_US */
};

typedef struct {
  uint8_t next;      /* number of the next frame, by count */
  uint8_t confirmed; /* last number that agreed */
  uint8_t missed;    /* frames after it are missing */
  uint8_t serial;    /* newest of a torque frame */
  uint16_t serials;  /* bit i: serial - i has been heard */
  uint8_t quiet;     /* epochs begun since a torque frame was heard for the first time */
  uint8_t kept;      /* the lower end was a child when it fell silent, and may not know that it was not heard */
} rs_arq_receiver;

/* The lower end has just become a child, and its next frame has this number. */
void rs_arq_receiver_start(rs_arq_receiver* arq_receiver, uint32_t number);

/* A frame that counts has come. */
RS_INLINE void rs_arq_receiver_count(rs_arq_receiver* arq_receiver) {
  arq_receiver->next = (uint8_t)((arq_receiver->next + 1U) & RS_NUMBER_MASK);
}

/* Whether a tick of the lower end with this number shows that nothing is missing; which then is confirmed. */
RS_INLINE bool rs_arq_receiver_agrees(const rs_arq_receiver* arq_receiver, uint32_t number) {
  return !arq_receiver->missed && (number & RS_NUMBER_MASK) == arq_receiver->next;
}
RS_INLINE void rs_arq_receiver_agree(rs_arq_receiver* arq_receiver) {
  arq_receiver->confirmed = arq_receiver->next;
}

/* A tick of the lower end has come; true if it shows for the first time that frames are missing. */
bool rs_arq_receiver_compare(rs_arq_receiver* arq_receiver, uint32_t number);

/* What is missing up to this number is given up. */
RS_INLINE void rs_arq_receiver_give_up(rs_arq_receiver* arq_receiver, uint32_t number) {
  arq_receiver->next = arq_receiver->confirmed = (uint8_t)(number & RS_NUMBER_MASK);
  arq_receiver->missed = false;
}

/* For the next tick to the lower end. */
RS_INLINE uint32_t rs_arq_receiver_ack(const rs_arq_receiver* arq_receiver) {
  return (uint32_t)(arq_receiver->confirmed & RS_NUMBER_MASK) | (arq_receiver->missed ? (uint32_t)RS_ARQ_MISSED : 0U);
}

/* Whether a torque frame with this serial is heard for the first time; it counts as heard from now on. */
bool rs_arq_receiver_first(rs_arq_receiver* arq_receiver, uint32_t serial);

/* An epoch begins. After some without a new torque frame no old one can come again, and the lower end may have rebooted
 * and count from the beginning, which its nonce hides once in 256: whatever comes next is heard for the first time. */
RS_INLINE void rs_arq_receiver_epoch(rs_arq_receiver* arq_receiver) {
  if (arq_receiver->quiet >= RS_SERIALS_KEPT_EPOCHS) return;
  if (++arq_receiver->quiet == RS_SERIALS_KEPT_EPOCHS) arq_receiver->serials = 0;
}

#ifdef __cplusplus
}
#endif

#endif
