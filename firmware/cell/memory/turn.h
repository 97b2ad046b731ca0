/* SPDX-License-Identifier: Apache-2.0
 * Which turn of the ticks' time it is, and the keys in force in it. */
#ifndef ROBOTSKIN_CELL_MEMORY_TURN_H
#define ROBOTSKIN_CELL_MEMORY_TURN_H

#include "robotskin/cell.h"

void rs_turn_take(rs_cell* cell, uint32_t turn);
/* The tick time goes on: whether a turn has ended is told by the last time that is known. */
void rs_turn_follow(rs_cell* cell, uint32_t time);

#endif
