/* SPDX-License-Identifier: Apache-2.0
 * When a cell samples, and which of its samples a rate divisor leaves out. */
#ifndef ROBOTSKIN_CELL_TIME_SAMPLE_CLOCK_H
#define ROBOTSKIN_CELL_TIME_SAMPLE_CLOCK_H

#include "robotskin/cell.h"

uint32_t rs_sampling_period_us(const rs_settings* settings); /* 0: never */
void rs_sampling_restart(rs_cell* cell, uint32_t now_us);    /* after a change of settings or id, or the first tick */
void rs_sampling_refresh(rs_cell* cell, uint32_t now_us);    /* a frame for freshness is due, soon */
void rs_sampling_check(rs_cell* cell, uint32_t now_us);      /* heals what damaged memory says of the next sample */
/* The next sample after one at `now_us`, or the first, if nothing was sampled. */
uint32_t rs_sampling_next_us(const rs_cell* cell, uint32_t period_us, bool sampled, uint32_t now_us);
/* Whether a divisor leaves out the sample that a cell took at a time. */
bool rs_sampling_divided_away(const rs_cell* cell, uint32_t id, uint32_t divisor, uint32_t period_us, uint32_t at_us);
/* Whether the rate divisor, or one of two while there is none, leaves out a sample of any cell that comes by. */
bool rs_sampling_left_out(const rs_cell* cell, const uint8_t* frame, uint32_t now_us);

#endif
