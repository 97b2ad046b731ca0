/* SPDX-License-Identifier: Apache-2.0
 * What one neighbour is. */
#ifndef ROBOTSKIN_CELL_LINK_LINK_H
#define ROBOTSKIN_CELL_LINK_LINK_H

#include "robotskin/cell.h"

bool rs_link_usable(const rs_neighbour* neighbour);            /* both hear each other */
void rs_link_damage(rs_neighbour* neighbour, uint32_t now_us); /* a damaged frame has come */
/* Whether so many frames from there are damaged that another line is better. */
bool rs_link_lossy(const rs_neighbour* neighbour, uint32_t now_us);
/* Whether a child has stayed behind the own ticks for longer than any move takes. */
bool rs_link_lagging(const rs_route* route, const rs_neighbour* neighbour, uint32_t now_us);
/* Whether a neighbour may become the parent by a move: its ticks come as fast as the own ones, and it stays. */
bool rs_move_open(const rs_route* route, const rs_neighbour* neighbour);
/* Whether the way up begins with a line that spoils frames. */
RS_INLINE bool rs_route_lossy(const rs_route* route, uint32_t now_us) {
  return route->parent_port != RS_NO_PARENT &&
         rs_link_lossy(&route->neighbour[(route->parent_port - 1U) % RS_PORTS], now_us);
}

#endif
