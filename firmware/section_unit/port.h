/* SPDX-License-Identifier: Apache-2.0
 * One port; ports are indices 0 to 14. */
#ifndef ROBOTSKIN_SECTION_UNIT_PORT_H
#define ROBOTSKIN_SECTION_UNIT_PORT_H

#include "robotskin/section_unit.h"

/* The number of a tree: its unit in the upper four bits, its port, counted from 1, in the lower. */
RS_INLINE uint8_t rs_root_number(unsigned unit, unsigned port) {
  return (uint8_t)(unit << 4 | (port + 1U));
}
RS_INLINE unsigned rs_unit_of_root(uint8_t root) {
  return root >> 4;
}
RS_INLINE unsigned rs_port_of_root(uint8_t root) {
  return (root & 0xFU) - 1U;
}
uint8_t rs_root_of(const rs_section_unit* unit, unsigned port);   /* of an own port's tree */
rs_wave rs_port_wave(const rs_section_unit* unit, unsigned port); /* what its ticks say to the tree */
bool rs_port_alive(const rs_unit_port* port, uint64_t now_ns);
void rs_ports_power(rs_section_unit* unit, unsigned port, bool on);
/* Puts a command or another downward frame into a port's queue; commands get their tag. */
void rs_ports_send(rs_section_unit* unit, unsigned port, const uint8_t* content);
void rs_ports_pack_tick(const rs_section_unit* unit, unsigned port, uint64_t now_ns, uint8_t* frame);
void rs_ports_transmit(rs_section_unit* unit, uint64_t now_ns, rs_unit_output* output);
uint64_t rs_ports_due(const rs_section_unit* unit); /* when a frame that waits may go down; UINT64_MAX: none waits */

#endif
