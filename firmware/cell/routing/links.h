/* SPDX-License-Identifier: Apache-2.0
 * Links that come up and fall (R1). */
#ifndef ROBOTSKIN_CELL_ROUTING_LINKS_H
#define ROBOTSKIN_CELL_ROUTING_LINKS_H

#include "robotskin/cell.h"

void rs_link_heard(rs_cell* cell, unsigned port, uint32_t now_us);
void rs_link_down(rs_cell* cell, unsigned port, uint32_t now_us);
void rs_links_check(rs_cell* cell, uint32_t now_us);

#endif
