/* SPDX-License-Identifier: Apache-2.0
 * What comes up at the ports, and what each tick asks of them. */
#ifndef ROBOTSKIN_SECTION_UNIT_PORTS_H
#define ROBOTSKIN_SECTION_UNIT_PORTS_H

#include "robotskin/section_unit.h"

void rs_ports_tick(rs_section_unit* unit, uint64_t now_ns);
void rs_ports_receive(rs_section_unit* unit, unsigned port, const uint8_t* frame, uint64_t now_ns);

#endif
