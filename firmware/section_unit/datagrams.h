/* SPDX-License-Identifier: Apache-2.0
 * Datagrams to the host and from it. */
#ifndef ROBOTSKIN_SECTION_UNIT_DATAGRAMS_H
#define ROBOTSKIN_SECTION_UNIT_DATAGRAMS_H

#include "robotskin/section_unit.h"

void rs_datagrams_receive(rs_section_unit* unit, const uint8_t* bytes, uint32_t count, uint64_t now_ns);
/* Writes at most one datagram; returns when the next one is due, if nothing comes before. */
uint64_t rs_datagrams_send(rs_section_unit* unit, uint64_t now_ns, rs_unit_output* output);

#endif
