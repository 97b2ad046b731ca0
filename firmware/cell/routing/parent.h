/* SPDX-License-Identifier: Apache-2.0
 * The parent of a cell (R2, R3, R5). */
#ifndef ROBOTSKIN_CELL_ROUTING_PARENT_H
#define ROBOTSKIN_CELL_ROUTING_PARENT_H

#include "robotskin/cell.h"

void rs_route_boot(rs_cell* cell, uint32_t now_us);
void rs_route_lose(rs_cell* cell, uint32_t now_us);                 /* R5 */
void rs_route_adopt(rs_cell* cell, unsigned port, uint32_t now_us); /* R3; only what is feasible */
void rs_route_beacon(rs_cell* cell, uint32_t now_us);               /* to every neighbour, now */
bool rs_route_feasible(const rs_route* route, unsigned port);       /* R2 */
bool rs_route_runs_ahead(const rs_route* route, const rs_neighbour* neighbour);
unsigned rs_route_best_feasible(const rs_route* route, uint32_t now_us); /* RS_PORTS: none is */
void rs_route_heal_distance(rs_route* route);                            /* from damaged memory */

#endif
