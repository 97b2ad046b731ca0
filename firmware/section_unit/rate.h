/* SPDX-License-Identifier: Apache-2.0
 * The rate divisor of a port. */
#ifndef ROBOTSKIN_SECTION_UNIT_RATE_H
#define ROBOTSKIN_SECTION_UNIT_RATE_H

#include "robotskin/section_unit.h"

void rs_rate_start(rs_unit_rate* rate);
/* Notes a frame that came up. */
void rs_rate_heard(rs_unit_rate* rate, const uint8_t* frame);
/* The host may have changed the cells' rate: the highest one is assumed until it is measured. */
void rs_rate_forget(rs_unit_rate* rate);
/* Once a millisecond; true if the divisor has changed. */
bool rs_rate_tick(rs_unit_rate* rate, uint32_t size);

#endif
