/* SPDX-License-Identifier: Apache-2.0
 * Copies of what a cell has sent to its parent and must not be lost, until they are of no use any more.
 *
 * Events and torque sums wait here to be sent, and stay here after that. What a hop has lost is sent again when the
 * parent's tick says so (arq_receiver.h). After a parent was lost, all events that may have died with it are sent again
 * to the new one; the host removes what it had already. A torque sum that may have reached a parent is never given to
 * another one: it would be counted twice. */
#ifndef ROBOTSKIN_ARQ_SENDER_H
#define ROBOTSKIN_ARQ_SENDER_H

#include <stdbool.h>
#include <stdint.h>

#include "robotskin/portable.h"
#include "robotskin/wire.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
  RS_ARQ_EVENTS = 128, /* powers of two */
  RS_ARQ_CROWDED = 96, /* where so many events wait, those that are missed would find no room */
  RS_ARQ_TORQUES = 16,
  RS_ANNOUNCEMENTS = 4
};

/* A ring of frames in the order of their coming; all but `first` are counted from there:
 * confirmed <= sent <= tried <= count. */
typedef struct {
  uint8_t first;
  uint8_t count;
  uint8_t sent;      /* to the present parent, since the last going back */
  uint8_t confirmed; /* heard by it */
  uint8_t tried;     /* sent at least once, to any parent */
} rs_arq_ring;

typedef struct {
  uint8_t number;
  uint8_t events, torques; /* sent before it */
} rs_announcement;

typedef struct {
  rs_arq_ring event, torque;
  rs_announcement announced[RS_ANNOUNCEMENTS]; /* not confirmed yet, oldest first */
  uint8_t announcements;
  uint8_t number; /* of the next frame, modulo 128 */
  uint8_t parent_port;
  uint8_t torque_serial;
  uint8_t was_lost;                     /* the last parent was not left but lost, */
  uint8_t was_silent;                   /* and what it had not passed on it will not */
  uint32_t silent_us;                   /* since when */
  uint32_t parent_changes;              /* known so far */
  uint32_t back_us;                     /* when it last went back */
  uint16_t event_time[RS_ARQ_EVENTS];   /* of the sample; cell's clock / 64 us */
  uint16_t torque_time[RS_ARQ_TORQUES]; /* of the sum; cell's clock / 64 us */
  RS_WORDS uint8_t event_frame[RS_ARQ_EVENTS][RS_FRAME_BYTES];
  RS_WORDS uint8_t torque_frame[RS_ARQ_TORQUES][RS_FRAME_BYTES];
} rs_arq_sender;

#ifdef __cplusplus
}
#endif

#endif
