/* SPDX-License-Identifier: Apache-2.0
 * A step the long way: whatever comes, and whatever is due. */
#ifndef ROBOTSKIN_CELL_SLOW_PATH_H
#define ROBOTSKIN_CELL_SLOW_PATH_H

#include "robotskin/cell.h"

void rs_step(rs_cell* cell, const rs_input* input, uint32_t now_us, rs_output* output);

#endif
