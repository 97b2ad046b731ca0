/* SPDX-License-Identifier: Apache-2.0
 * Planned changes of parent (R10). */
#ifndef ROBOTSKIN_CELL_ROUTING_MOVES_H
#define ROBOTSKIN_CELL_ROUTING_MOVES_H

#include "robotskin/cell.h"

void rs_move_grant(rs_cell* cell, unsigned port, const uint8_t* frame, uint32_t now_us); /* a grant frame */
/* Leaves a parent that is about to leave the tree for an equally near one that stays; false if there is none. */
bool rs_move_shed(rs_cell* cell, uint32_t now_us);
/* Begins to leave a parent that hangs at the border for a farther one that does not. */
void rs_move_detour(rs_cell* cell, uint32_t now_us);
/* What a beacon of another neighbour than the parent means for a move; true if the cell has moved. */
bool rs_move_advance(rs_cell* cell, unsigned port, uint32_t now_us);
void rs_move_check(rs_cell* cell, uint32_t now_us);

#endif
