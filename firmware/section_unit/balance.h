/* SPDX-License-Identifier: Apache-2.0
 * Rounds of offers and grants. */
#ifndef ROBOTSKIN_SECTION_UNIT_BALANCE_H
#define ROBOTSKIN_SECTION_UNIT_BALANCE_H

#include "robotskin/section_unit.h"

void rs_balance_tick(rs_section_unit* unit, uint64_t now_ns);
void rs_balance_status(rs_section_unit* unit, unsigned port, const rs_status* status);
/* The own trees as records of a datagram; how many. */
uint32_t rs_balance_pack(const rs_section_unit* unit, uint8_t* records, uint64_t now_ns);

#endif
