/* SPDX-License-Identifier: Apache-2.0
 * What a tree wants to give to its neighbours in a round: half of what it has more than they, and never so much that
 * the tree that takes becomes fuller than the one that gives. */
#include "section_unit/demands.h"

#include "section_unit/trees.h"

#define MOST_WANTED RS_FIELD_MAX(grant_demand_1_size)

enum {
  DECIDE_TICKS = 2,    /* offers are collected so long, and while the tree is crossed */
  DETOUR_TICKS = 10,   /* in a last resort so much longer, until trunks at the border have become light */
  PATIENCE_TICKS = 64, /* longest further wait, so that others are asked, too */
  LAST_RESORTS = 16,   /* in a row; offers came after 10 at the latest, and each moves cells of a tree at rest */
  RESORT_ROUNDS = 256  /* in which there are so many: a skin whose loads cannot become even comes to rest */
};

void rs_demand_remove(rs_unit_balance* balance, unsigned w) {
  for (; w + 1U < RS_DEMANDS; ++w) {
    balance->demand_root[w] = balance->demand_root[w + 1U];
    balance->demand_size[w] = balance->demand_size[w + 1U];
  }
  balance->demand_root[w] = 0;
  balance->demand_size[w] = 0;
}

void rs_demands_close(rs_unit_balance* balance) {
  for (unsigned w = 0; w < RS_DEMANDS; ++w) rs_demand_remove(balance, 0);
}

uint32_t rs_demands_given(const rs_section_unit* unit, unsigned port, uint8_t root) {
  uint32_t given = 0;
  for (unsigned p = 0; p < unit->config.ports; ++p) {
    const rs_unit_balance* other = &unit->port[p].balance;
    if (p == port || (!other->open && unit->tick_time >= other->busy_until)) continue;
    for (unsigned w = 0; w < RS_DEMANDS; ++w) {
      if (other->given_root[w] == root) given += other->given[w];
    }
  }
  return given;
}

/* By how many cells tree j is smaller than tree k, with what other ports are giving it already. Cells go downhill only,
 * and so many at most: no cable becomes fuller than the one that gives, and loads no less even, whatever becomes of
 * what j is to pass on. A port that found no offer in many rounds keeps no other from giving. */
static uint32_t gap_to(const rs_section_unit* unit, const rs_trees* trees, unsigned k, unsigned j) {
  uint32_t taken = trees->size[j] + rs_demands_given(unit, trees->port[k], trees->root[j]);
  for (unsigned port = 0; port < unit->config.ports; ++port) {
    const rs_unit_balance* other = &unit->port[port].balance;
    if (port == trees->port[k] || !other->open || rs_demands_stuck(other)) continue;
    for (unsigned w = 0; w < RS_DEMANDS; ++w) {
      if (other->demand_root[w] == trees->root[j]) taken += other->demand_size[w];
    }
  }
  return trees->size[k] > taken ? trees->size[k] - taken : 0U;
}

/* How much of that tree j may take. One that does not pass cells on takes no more than brings the two level, because
 * what it takes beyond that stays there. */
static uint32_t room(const rs_section_unit* unit, const rs_trees* trees, unsigned j, uint32_t gap) {
  const bool stuck = trees->port[j] != RS_TREE_FOREIGN && rs_demands_stuck(&unit->port[trees->port[j]].balance);
  return stuck ? gap / 2U : gap;
}

/* Places what neighbour `root` is to get among the wants, the largest surplus first. */
static void want(rs_unit_balance* balance, uint32_t surplus[RS_DEMANDS], uint32_t more, uint8_t root, uint32_t size,
                 uint32_t gap) {
  unsigned w = 0;
  while (w < RS_DEMANDS && balance->demand_root[w] != 0U && surplus[w] >= more) ++w;
  if (w == RS_DEMANDS) return;
  for (unsigned last = RS_DEMANDS - 1U; last > w; --last) {
    surplus[last] = surplus[last - 1U];
    balance->demand_root[last] = balance->demand_root[last - 1U];
    balance->demand_size[last] = balance->demand_size[last - 1U];
    balance->gap[last] = balance->gap[last - 1U];
  }
  surplus[w] = more;
  balance->demand_root[w] = root;
  balance->demand_size[w] = (uint16_t)size;
  balance->gap[w] = (uint16_t)gap;
}

/* How much longer than usual an offer is waited for, which climbs a deep tree slowly where that has much to tell. */
static uint64_t patience(const rs_unit_port* port) {
  const unsigned failed = port->balance.failed;
  if (failed <= RS_FAILED_ROUNDS) return 0;
  const uint32_t longer = (uint32_t)port->height << (failed - RS_FAILED_ROUNDS < 3U ? failed - RS_FAILED_ROUNDS : 3U);
  return longer < PATIENCE_TICKS ? longer : PATIENCE_TICKS;
}

void rs_demands_start(rs_section_unit* unit, const rs_trees* trees, unsigned k) {
  rs_unit_port* here = &unit->port[trees->port[k]];
  rs_unit_balance* balance = &here->balance;
  rs_demands_close(balance);
  uint32_t surplus[RS_DEMANDS] = {0, 0, 0};
  for (unsigned j = 0; j < trees->count; ++j) {
    if (!rs_trees_beside(trees, k, j) || trees->size[k] <= trees->size[j] + 1U) continue;
    const uint32_t more = (uint32_t)trees->size[k] - trees->size[j];
    uint32_t size = (more + 1U) / 2U; /* that makes the two level */
    if (size > MOST_WANTED) size = MOST_WANTED;
    const uint32_t gap = gap_to(unit, trees, k, j), most_taken = room(unit, trees, j, gap);
    if (most_taken == 0U) continue;
    if (size > most_taken) size = most_taken;
    want(balance, surplus, more, trees->root[j], size, gap);
  }
  if (balance->demand_root[0] == 0U) {
    balance->failed = 0;
    return;
  }
  for (unsigned w = 0; w < RS_DEMANDS; ++w) {
    balance->given_root[w] = balance->demand_root[w];
    balance->given[w] = 0;
  }
  balance->open = true;
  balance->last_resort = balance->failed > 0U && balance->failed % RESORT_ROUNDS < LAST_RESORTS;
  balance->round = (balance->round + 1U) & 7U;
  balance->demand_left = 2;
  balance->opened_at = unit->tick_time;
  balance->decide_at = unit->tick_time + DECIDE_TICKS + rs_there_and_back(here);
  if (balance->last_resort) balance->decide_at += DETOUR_TICKS;
  balance->close_at = balance->decide_at + RS_OFFER_TICKS + patience(here);
  if (++balance->failed == 2U * RESORT_ROUNDS) balance->failed = RESORT_ROUNDS; /* until an offer comes */
  for (unsigned i = 0; i < RS_UNIT_GRANTED; ++i) balance->granted[i] = RS_ID_NONE;
}
