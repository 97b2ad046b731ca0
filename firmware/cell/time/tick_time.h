/* SPDX-License-Identifier: Apache-2.0
 * What time it is for the whole group. */
#ifndef ROBOTSKIN_CELL_TIME_TICK_TIME_H
#define ROBOTSKIN_CELL_TIME_TICK_TIME_H

#include "robotskin/cell.h"

uint32_t rs_tick_time(const rs_cell* cell, uint32_t now_us); /* milliseconds, RS_TICK_TIME_BITS bits */
/* Age of a sample by its frame. What a cell holds for longer than the sample times go round never gets here. */
uint32_t rs_sample_age_us(const rs_cell* cell, const uint8_t* frame, uint32_t now_us);

#endif
