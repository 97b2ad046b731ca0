/* SPDX-License-Identifier: Apache-2.0
 * Frames on their way to the host. */
#ifndef ROBOTSKIN_SECTION_UNIT_UPLINK_H
#define ROBOTSKIN_SECTION_UNIT_UPLINK_H

#include "robotskin/section_unit.h"

bool rs_host_listens(const rs_section_unit* unit, uint64_t now_ns);
/* `port` is counted from 1 here, 0: the unit itself. */
void rs_datagrams_gather(rs_section_unit* unit, unsigned port, const uint8_t* frame, uint64_t now_ns);
/* Completes the datagram whose `count` records stand in place already. */
void rs_datagram_finish(rs_section_unit* unit, rs_datagram_kind kind, uint32_t count, uint64_t now_ns,
                        rs_unit_output* output);

#endif
