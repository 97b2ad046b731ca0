/* SPDX-License-Identifier: Apache-2.0
 * How many cells a tree is to give, and to which others. */
#ifndef ROBOTSKIN_SECTION_UNIT_DEMANDS_H
#define ROBOTSKIN_SECTION_UNIT_DEMANDS_H

#include "robotskin/section_unit.h"
#include "section_unit/trees.h"

enum {
  RS_OFFER_TICKS = 3,  /* without a further offer, and while the tree is crossed, a round is over */
  RS_FAILED_ROUNDS = 2 /* without an offer, after which a tree is taken for one that gives nothing */
};
/* Down and up a tree so deep takes about so many ticks. */
RS_INLINE uint64_t rs_there_and_back(const rs_unit_port* port) {
  return (3U * (uint32_t)port->height) / 8U;
}
/* Opens a round of own tree k, if it has anything to give. */
void rs_demands_start(rs_section_unit* unit, const rs_trees* trees, unsigned k);
/* Whether a tree is taken for one that gives nothing. */
RS_INLINE bool rs_demands_stuck(const rs_unit_balance* balance) {
  return balance->failed > RS_FAILED_ROUNDS;
}
/* Cells that other ports than `port` have granted to tree `root` in rounds that are not over. */
uint32_t rs_demands_given(const rs_section_unit* unit, unsigned port, uint8_t root);
void rs_demand_remove(rs_unit_balance* balance, unsigned w);
void rs_demands_close(rs_unit_balance* balance);

#endif
