/* SPDX-License-Identifier: Apache-2.0
 * What a cell does about its parent (R4, R6 to R9). */
#ifndef ROBOTSKIN_CELL_ROUTING_ROUTE_H
#define ROBOTSKIN_CELL_ROUTING_ROUTE_H

#include "robotskin/cell.h"

void rs_route_turn(rs_cell* cell, unsigned port, uint32_t now_us); /* after what a neighbour has said */
void rs_route_check(rs_cell* cell, uint32_t now_us);

#endif
