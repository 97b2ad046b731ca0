/* SPDX-License-Identifier: Apache-2.0
 * The next frame of each idle port. */
#ifndef ROBOTSKIN_CELL_TRANSMIT_H
#define ROBOTSKIN_CELL_TRANSMIT_H

#include <stddef.h>

#include "cell/transport/rings.h"
#include "cell/wire/ports.h"
#include "robotskin/cell.h"

enum { RS_SLOW_SHARE = 8 }; /* one report or request goes up for so many other frames, if any waits */

void rs_transmit(rs_cell* cell, uint32_t now_us, rs_output* output);
/* Starts a frame on each of these ports (bit p: port p) that has one; on which it did. */
unsigned rs_transmit_start(rs_cell* cell, unsigned ready, uint32_t now_us);

/* Tells the frames that have started. */
RS_INLINE void rs_output_start(rs_output* output, const rs_queues* queues, unsigned started) {
  for (unsigned port = 0; port < RS_PORTS; ++port) output->frame[port] = NULL;
  for (unsigned port = 0; started != 0U; ++port, started >>= 1) {
    if ((started & 1U) != 0U) output->frame[port % RS_PORTS] = rs_sending_last(queues, port % RS_PORTS);
  }
}

/* Ports with something to send, now or as soon as they are free. */
RS_INLINE unsigned rs_transmit_wanted(const rs_cell* cell) {
  const rs_queues* queues = &cell->queues;
  if (queues->down.count > 0U) return RS_ALL_PORTS;
  const unsigned parent = 1U << cell->route.parent_port >> 1;
  return (queues->beacon_due | (queues->status_due || rs_cell_waiting(cell) > 0U ? parent : 0U)) & RS_ALL_PORTS;
}

/* Whether a sample is the next frame for the parent, if one waits; as long as it is calm, that remains so until a
 * report or request has its turn. */
RS_INLINE bool rs_samples_next(const rs_cell* cell) {
  const rs_queues* queues = &cell->queues;
  const rs_arq_sender* arq_sender = &cell->arq_sender;
  return (queues->beacon_due & queues->parent_bit) == 0U && (queues->status_due | queues->data_again) == 0U &&
         (queues->slow.count == 0U || queues->passed_over < RS_SLOW_SHARE) &&
         arq_sender->event.sent >= arq_sender->event.count && arq_sender->torque.sent >= arq_sender->torque.count;
}

#endif
