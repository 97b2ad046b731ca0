/* SPDX-License-Identifier: Apache-2.0
 * The torque that touch on this cell means for the joints below it. */
#ifndef ROBOTSKIN_CELL_TORQUE_CELL_TORQUE_H
#define ROBOTSKIN_CELL_TORQUE_CELL_TORQUE_H

#include "robotskin/cell.h"

void rs_cell_torque_load(rs_cell* cell); /* from the cell's flash image */
void rs_cell_torque_feel(rs_cell* cell, const rs_sample* calibrated, uint32_t now_us);
/* What the cell adds to its limb's sum in an epoch, by what it has felt and how the joints stand. */
void rs_cell_torque_update(rs_cell* cell, uint32_t epoch, uint32_t now_us);
void rs_cell_torque_write(rs_cell* cell, const rs_command* word); /* of an index that there is */
bool rs_cell_torque_commit(rs_cell* cell, uint32_t checksum);     /* false: what was written is not that */
uint32_t rs_cell_torque_checksum(const rs_cell* cell);            /* of what is in force, 65536: nothing is */

#endif
