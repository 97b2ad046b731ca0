/* SPDX-License-Identifier: Apache-2.0
 * What the last parent may not have passed on. */
#ifndef ROBOTSKIN_CELL_TRANSPORT_PARENT_CHANGE_H
#define ROBOTSKIN_CELL_TRANSPORT_PARENT_CHANGE_H

#include "robotskin/cell.h"

void rs_arq_sender_move(rs_cell* cell, uint32_t now_us); /* the parent has changed */

#endif
