/* SPDX-License-Identifier: Apache-2.0
 * When the cell has something to do again without being asked. */
#ifndef ROBOTSKIN_CELL_TIME_TIMER_H
#define ROBOTSKIN_CELL_TIME_TIMER_H

#include "robotskin/cell.h"

/* When the next check is due; called after each change of one of its reasons. */
void rs_timer_set(rs_cell* cell, uint32_t now_us);

uint32_t rs_beacon_wait_us(const rs_cell* cell, unsigned port, uint32_t now_us); /* until it may be sent; 0: now */
uint32_t rs_status_wait_us(const rs_cell* cell, uint32_t now_us);                /* likewise */
void rs_status_note(rs_cell* cell, uint32_t now_us);                             /* one is sent */
uint32_t rs_torque_wait_us(const rs_cell* cell, uint32_t now_us);

/* After so long a move is given up. */
RS_INLINE uint32_t rs_move_longest_us(const rs_route* route) {
  return route->target_root == route->wave.root ? RS_DETOUR_US : RS_HOLD_US;
}

#endif
