/* SPDX-License-Identifier: Apache-2.0
 * Joint positions, broadcast down the tree. */
#ifndef ROBOTSKIN_CELL_TORQUE_JOINTS_H
#define ROBOTSKIN_CELL_TORQUE_JOINTS_H

#include "robotskin/cell.h"

void rs_joints_receive(rs_cell* cell, unsigned port, const uint8_t* frame, uint32_t now_us);

#endif
