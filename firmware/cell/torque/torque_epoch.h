/* SPDX-License-Identifier: Apache-2.0
 * One epoch of a cell: torque sums on their way up. */
#ifndef ROBOTSKIN_CELL_TORQUE_TORQUE_EPOCH_H
#define ROBOTSKIN_CELL_TORQUE_TORQUE_EPOCH_H

#include "robotskin/cell.h"

/* `late_us`: the frame waited so long for the processor. */
void rs_torque_receive(rs_cell* cell, unsigned port, const uint8_t* frame, uint32_t late_us, uint32_t now_us);
/* Begins epochs and ends them; `late_us` of the input at hand. */
void rs_torque_advance(rs_cell* cell, uint32_t late_us, uint32_t now_us);
void rs_torque_check(rs_cell* cell);

#endif
