/* SPDX-License-Identifier: Apache-2.0
 * What follows from a wrong tag. */
#ifndef ROBOTSKIN_CELL_ROUTING_REFUSAL_H
#define ROBOTSKIN_CELL_ROUTING_REFUSAL_H

#include "robotskin/cell.h"

/* A wrong tag came at a place (wrong_tags.h): it is counted. Once the budget is spent, the port's link falls, and the
 * host is told. */
void rs_refuse_tag(rs_cell* cell, unsigned place, uint32_t now_us);

#endif
