/* SPDX-License-Identifier: Apache-2.0
 * Wrong tags have a budget: guessing has to end, however fast a line is.
 *
 * A place is a port, or RS_UNREAD: what a good neighbour passes on without being able to tell whether it is right
 * (a command under this cell's own key, or any from a parent without a name). For that no port is closed, as it may be
 * another's forgery; such frames are no longer read instead. */
#ifndef ROBOTSKIN_CELL_ROUTING_WRONG_TAGS_H
#define ROBOTSKIN_CELL_ROUTING_WRONG_TAGS_H

#include "robotskin/cell.h"

/* Count a wrong tag; whether the place's budget is spent, so that it closes. What follows from that: refusal.h. */
bool rs_tags_spend(rs_cell* cell, unsigned place);
bool rs_tags_closed(const rs_cell* cell, unsigned place);
/* The lowest place that is closed, or was so lately, counted from 1; 0: none. */
unsigned rs_tags_told(const rs_cell* cell);
/* One of each place once in RS_TAG_FORGIVEN_US. */
void rs_tags_forgive(rs_cell* cell, uint32_t now_us);

#endif
