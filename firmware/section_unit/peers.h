/* SPDX-License-Identifier: Apache-2.0
 * The other units of the group. */
#ifndef ROBOTSKIN_SECTION_UNIT_PEERS_H
#define ROBOTSKIN_SECTION_UNIT_PEERS_H

#include "robotskin/section_unit.h"

void rs_peers_keep_time(rs_section_unit* unit, uint64_t now_ns); /* once a tick */
/* As rs_datagrams_send. */
uint64_t rs_peers_send(rs_section_unit* unit, uint64_t now_ns, rs_unit_output* output);
/* A datagram whose tag is right; false if it is of no use. */
bool rs_peers_receive(rs_section_unit* unit, const rs_datagram_header* header, const uint8_t* bytes, uint64_t now_ns);

#endif
