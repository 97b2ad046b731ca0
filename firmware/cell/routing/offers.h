/* SPDX-License-Identifier: Apache-2.0
 * Which cell of the subtree could move to another tree. */
#ifndef ROBOTSKIN_CELL_ROUTING_OFFERS_H
#define ROBOTSKIN_CELL_ROUTING_OFFERS_H

#include "robotskin/cell.h"

bool rs_demands_open(const rs_route* route);
/* The better of a subtree's best offer and another one, or the own one. */
void rs_offer_own(const rs_cell* cell, rs_offer* best);
void rs_offer_better(const rs_route* route, const rs_offer* offer, rs_offer* best);

#endif
