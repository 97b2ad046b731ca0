/* SPDX-License-Identifier: Apache-2.0
 * Frames that wait for the parent and for the children. */
#ifndef ROBOTSKIN_CELL_TRANSPORT_QUEUES_H
#define ROBOTSKIN_CELL_TRANSPORT_QUEUES_H

#include "robotskin/cell.h"

bool rs_queue_up(rs_cell* cell, const uint8_t* frame,
                 uint32_t now_us);                       /* by its type; false: no room. It begins at a whole word */
void rs_queue_down(rs_cell* cell, const uint8_t* frame); /* to every child */
/* The subtree has another size than before. If it has grown to more than a line carries, every other sample is left
 * out, those that a rate divisor of two would leave out as well, until the section unit has had time to tell its own.
 */
void rs_queues_throttle(rs_cell* cell, uint32_t before, uint32_t size);
RS_INLINE void rs_queues_relax(rs_cell* cell) { /* with each tick */
  uint8_t* most = &cell->queues.data_most;
  if (*most < RS_QUEUE_DATA) *most = *most < RS_QUEUE_CALMED ? (uint8_t)(*most + 1U) : (uint8_t)RS_QUEUE_DATA;
}
void rs_queues_forget_samples(rs_cell* cell);
void rs_queues_turn(rs_cell* cell); /* nothing waits to go down to the parent, which was a child perhaps */
/* The last samples wait again, */
void rs_queues_repeat_lost(rs_cell* cell, uint32_t since_us, uint32_t now_us); /* as the parent was silent since then */
void rs_queues_repeat_lossy(rs_cell* cell, uint32_t now_us);                   /* as few frames come through to it */
void rs_queues_check(rs_cell* cell, uint32_t now_us);

#endif
