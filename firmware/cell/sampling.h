/* SPDX-License-Identifier: Apache-2.0
 * Samples: what a cell measures, and what of it goes out. */
#ifndef ROBOTSKIN_CELL_SAMPLING_H
#define ROBOTSKIN_CELL_SAMPLING_H

#include "robotskin/cell.h"

void rs_sampling_take(rs_cell* cell, const rs_sample* sample, bool fault, uint32_t now_us);

#endif
