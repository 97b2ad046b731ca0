/* SPDX-License-Identifier: Apache-2.0
 * Events and torque sums, kept until they need not be sent again. */
#ifndef ROBOTSKIN_CELL_TRANSPORT_ARQ_SENDER_H
#define ROBOTSKIN_CELL_TRANSPORT_ARQ_SENDER_H

#include "robotskin/cell.h"

/* Take a frame to be sent to the parent and kept for a while; false: no room. An event that is here already counts as
 * taken; a torque sum gets its serial. */
bool rs_arq_sender_event(rs_cell* cell, const uint8_t* frame, uint32_t now_us);
bool rs_arq_sender_torque(rs_cell* cell, const rs_torque* torque, uint32_t now_us);
bool rs_arq_sender_torque_waits(const rs_cell* cell);
bool rs_arq_sender_next_event(rs_cell* cell, uint8_t* frame, uint32_t now_us);
bool rs_arq_sender_next_torque(rs_cell* cell, uint8_t* frame, uint32_t now_us);
/* A tick has come: of the parent, or of a child (`was_child`: that was one before). */
void rs_arq_sender_tick(rs_cell* cell, unsigned port, const rs_tick* tick, bool was_child, uint32_t now_us);
/* A tick of a child says that its next frame has this number: whether frames are missing that it shall send again. */
bool rs_arq_missed(rs_cell* cell, unsigned port, uint32_t number);
uint32_t rs_arq_sender_announce(rs_cell* cell); /* `ack` of the next tick to the parent */
void rs_arq_sender_check(rs_cell* cell, uint32_t now_us);

#endif
