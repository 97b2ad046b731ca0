/* SPDX-License-Identifier: Apache-2.0
 * What a cell says of itself: its id and its neighbours. */
#ifndef ROBOTSKIN_CELL_ROUTING_IDENTITY_H
#define ROBOTSKIN_CELL_ROUTING_IDENTITY_H

#include "robotskin/cell.h"

void rs_identity_boot(rs_cell* cell, uint32_t random, uint32_t now_us);
void rs_identity_changed(rs_cell* cell, uint32_t now_us); /* a report is due soon */
void rs_identity_check(rs_cell* cell, uint32_t now_us);
void rs_identity_assign(rs_cell* cell, uint16_t id, uint32_t now_us);
void rs_identity_rejoin(rs_cell* cell, uint32_t now_us);

#endif
