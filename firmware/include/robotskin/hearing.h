/* SPDX-License-Identifier: Apache-2.0
 * What the upper end of a link has heard of the frames that must not be lost: events and torque sums.
 *
 * Such frames carry no number of the link. Both ends count them instead, modulo 128: the lower end says in each of its
 * ticks the number that the next one will have (`echo`), the upper end compares it with what it has counted. As a wire
 * keeps the order, a number that agrees confirms all before it. The upper end answers in its own ticks with the last
 * number that agreed and, in the top bit, whether frames have been missed since; it then goes on missing until the
 * lower end goes back to that number and sends again from there (go-back-N, see retention.h). */
#ifndef ROBOTSKIN_HEARING_H
#define ROBOTSKIN_HEARING_H

#include <stdbool.h>
#include <stdint.h>

#include "robotskin/portable.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
  RS_NUMBER_MASK = 0x7F,
  RS_ECHO_MISSED = 0x80,
  RS_SERIAL_MASK = 0x1F,     /* serials of torque frames */
  RS_SERIALS_REMEMBERED = 16 /* at most half of the serials */
};

typedef struct {
  uint8_t next;      /* number of the next frame, by count */
  uint8_t confirmed; /* last number that agreed */
  uint8_t missed;    /* frames after it are missing */
  uint8_t serial;    /* newest of a torque frame */
  uint16_t serials;  /* bit i: serial - i has been heard */
  uint8_t kept;      /* the lower end was a child when it fell silent, and may not know that it was not heard */
} rs_hearing;

/* The lower end has just become a child, and its next frame has this number. */
void rs_hearing_start(rs_hearing* hearing, uint32_t number);

/* A frame that counts has come. */
RS_INLINE void rs_hearing_count(rs_hearing* hearing) {
  hearing->next = (uint8_t)((hearing->next + 1U) & RS_NUMBER_MASK);
}

/* A tick of the lower end has come; true if it shows for the first time that frames are missing. */
bool rs_hearing_compare(rs_hearing* hearing, uint32_t number);

/* For the next tick to the lower end. */
RS_INLINE uint32_t rs_hearing_echo(const rs_hearing* hearing) {
  return (uint32_t)(hearing->confirmed & RS_NUMBER_MASK) | (hearing->missed ? (uint32_t)RS_ECHO_MISSED : 0U);
}

/* Whether a torque frame with this serial is heard for the first time; it counts as heard from now on. */
bool rs_hearing_first(rs_hearing* hearing, uint32_t serial);

#ifdef __cplusplus
}
#endif

#endif
