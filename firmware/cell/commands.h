/* SPDX-License-Identifier: Apache-2.0
 * Commands to this cell, and those that pass. */
#ifndef ROBOTSKIN_CELL_COMMANDS_H
#define ROBOTSKIN_CELL_COMMANDS_H

#include "robotskin/cell.h"

void rs_command_receive(rs_cell* cell, unsigned port, const uint8_t* frame, uint32_t now_us);

#endif
