/* SPDX-License-Identifier: Apache-2.0
 * Torque sums of the ports, added up. */
#ifndef ROBOTSKIN_SECTION_UNIT_TORQUE_H
#define ROBOTSKIN_SECTION_UNIT_TORQUE_H

#include "robotskin/section_unit.h"

void rs_unit_torque_tick(rs_section_unit* unit, uint64_t now_ns);
void rs_unit_torque_receive(rs_section_unit* unit, unsigned port, const uint8_t* frame, uint64_t now_ns);
/* Hands over what is due; when the next is. */
uint64_t rs_unit_torque_end(rs_section_unit* unit, uint64_t now_ns);

#endif
