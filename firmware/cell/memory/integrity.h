/* SPDX-License-Identifier: Apache-2.0
 * Whether memory still says what was written. */
#ifndef ROBOTSKIN_CELL_MEMORY_INTEGRITY_H
#define ROBOTSKIN_CELL_MEMORY_INTEGRITY_H

#include "robotskin/cell.h"

/* Notes that uid, id or key are as they should be, and tells whether they still are. */
void rs_cell_seal(rs_cell* cell);
bool rs_cell_sealed(const rs_cell* cell);

/* Indices that damaged memory could carry out of their arrays before the next check. */
RS_INLINE void rs_cell_hold_indices(rs_cell* cell) {
  if (cell->route.parent_port > RS_PORTS) cell->route.parent_port = RS_NO_PARENT;
  if (cell->arq_sender.announcements > RS_ANNOUNCEMENTS) cell->arq_sender.announcements = 0;
  if (cell->torque.used > RS_TORQUE_SLOTS) cell->torque.used = 0;
}

/* A sum of whole halfwords, `count` bytes of them; never 0. */
uint32_t rs_sum_of(const void* halfwords, uint32_t count);

/* Notes that the settings are as they should be; heals them if they are not, from the copy or from flash. */
void rs_cell_keep_settings(rs_cell* cell);
void rs_cell_heal_settings(rs_cell* cell, uint32_t now_us);

#endif
