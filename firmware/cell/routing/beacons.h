/* SPDX-License-Identifier: Apache-2.0
 * What the neighbours say of themselves (R8). */
#ifndef ROBOTSKIN_CELL_ROUTING_BEACONS_H
#define ROBOTSKIN_CELL_ROUTING_BEACONS_H

#include "robotskin/cell.h"

void rs_beacon_tick(rs_cell* cell, unsigned port, const uint8_t* frame, uint32_t came_us, uint32_t now_us);

#endif
