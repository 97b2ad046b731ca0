/* SPDX-License-Identifier: Apache-2.0
 * What a cell tells its parent of its subtree. */
#ifndef ROBOTSKIN_CELL_ROUTING_SUBTREE_H
#define ROBOTSKIN_CELL_ROUTING_SUBTREE_H

#include "robotskin/cell.h"

void rs_subtree_update(rs_cell* cell);
void rs_subtree_forget(rs_neighbour* neighbour); /* a new child has not reported yet */
void rs_subtree_status(rs_cell* cell, unsigned port, const uint8_t* frame);
void rs_subtree_pack(rs_cell* cell, uint8_t* frame);

#endif
