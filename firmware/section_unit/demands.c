/* SPDX-License-Identifier: Apache-2.0
 * What a tree wants to give to its neighbours in a round: the flows of trees.c that are worth a move, and never so much
 * that the tree that takes becomes fuller than the one that gives. */
#include "section_unit/demands.h"

#include "section_unit/trees.h"

#define MOST_WANTED RS_FIELD_MAX(grant_demand_1_size)

enum {
  DECIDE_TICKS = 2,  /* offers are collected so long, and while the tree is crossed */
  DETOUR_TICKS = 10, /* in a last resort so much longer, until trunks at the border have become light */
  FLOW_LEAST = RS_POTENTIAL_SCALE / 50,
  FLOW_WHOLE = RS_POTENTIAL_SCALE * 15 / 16
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

/* By how many cells tree j is smaller than tree k, with what other ports are giving it already. Cells go downhill only,
 * and so many at most: no cable becomes fuller than the one that gives, and loads no less even, whatever becomes of
 * what j is to pass on. */
static uint32_t gap_to(const rs_section_unit* unit, const rs_trees* trees, unsigned k, unsigned j) {
  uint32_t taken = trees->size[j];
  for (unsigned port = 0; port < unit->config.ports; ++port) {
    const rs_unit_balance* other = &unit->port[port].balance;
    if (port == trees->port[k]) continue;
    for (unsigned w = 0; w < RS_DEMANDS; ++w) {
      if (other->open && other->demand_root[w] == trees->root[j]) taken += other->demand_size[w];
      const bool counts = other->open || unit->tick_time < other->busy_until;
      if (counts && other->given_root[w] == trees->root[j]) taken += other->given[w];
    }
  }
  return trees->size[k] > taken ? trees->size[k] - taken : 0U;
}

/* How much of that tree j may take. One that does not pass cells on takes no more than brings the two level, because
 * what it takes beyond that stays there. */
static uint32_t room(const rs_section_unit* unit, const rs_trees* trees, unsigned j, uint32_t gap) {
  const bool stuck = trees->port[j] != RS_TREE_FOREIGN && unit->port[trees->port[j]].balance.failed > RS_FAILED_ROUNDS;
  return stuck ? gap / 2U : gap;
}

/* What a tree gives to its neighbours: the flows that are worth a move, largest first. */
void rs_demands_start(rs_section_unit* unit, const rs_trees* trees, unsigned k, uint32_t cells, uint32_t count,
                      const rs_unit_balance* lead) {
  const uint32_t mean = cells / count, ideal = (cells + count - 1U) / count;
  rs_unit_port* here = &unit->port[trees->port[k]];
  rs_unit_balance* balance = &here->balance;
  /* If no cell offers where the flow is, a round about way may do; for a while. */
  const bool desperate = balance->failed >= RS_FAILED_ROUNDS && lead->stalled < 4U * RS_STALLED_ROUNDS;
  rs_demands_close(balance);
  int64_t taken[RS_DEMANDS] = {0, 0, 0};
  const uint32_t excess = trees->size[k] > mean ? trees->size[k] - mean : 1U;
  for (unsigned j = 0; j < trees->count; ++j) {
    if (!rs_trees_beside(trees, k, j)) continue;
    int64_t flow = unit->potential[trees->root[k]] - unit->potential[trees->root[j]];
    const int64_t whole = (flow + RS_POTENTIAL_SCALE / 2) / RS_POTENTIAL_SCALE;
    /* A flow of less than a cell is worth a move only if it levels, or if the tree is too large: not from 11 to 10. */
    const bool levels = trees->size[k] > trees->size[j] + 1U || (desperate && trees->size[k] > ideal);
    if (flow <= FLOW_LEAST || (!levels && (whole < 1 || (flow < FLOW_WHOLE && trees->size[k] <= ideal)))) continue;
    uint32_t size = whole<1 ? 1U : whole>(int64_t) MOST_WANTED ? MOST_WANTED : (uint32_t)whole;
    /* Never more than the own excess, unless that still levels; all that levels, if no cell offered less. */
    const uint32_t levelling = trees->size[k] > trees->size[j] + 1U ? trees->size[k] - trees->size[j] - 1U : 1U;
    if (size > excess && size > levelling) size = excess > levelling ? excess : levelling;
    if (balance->failed > 0U && levelling > size) size = levelling > MOST_WANTED ? MOST_WANTED : levelling;
    uint32_t gap = gap_to(unit, trees, k, j);
    const uint32_t most_taken = room(unit, trees, j, gap);
    if (most_taken == 0U) continue;
    if (size > most_taken) size = most_taken;
    uint8_t root = trees->root[j];
    for (unsigned w = 0; w < RS_DEMANDS; ++w) {
      if (balance->demand_root[w] != 0U && taken[w] >= flow) continue;
      const int64_t other_flow = taken[w];
      const uint8_t other_root = balance->demand_root[w];
      const uint16_t other_size = balance->demand_size[w], other_gap = balance->gap[w];
      taken[w] = flow;
      balance->demand_root[w] = root;
      balance->demand_size[w] = (uint16_t)size;
      balance->gap[w] = (uint16_t)gap;
      flow = other_flow;
      root = other_root;
      size = other_size;
      gap = other_gap;
      if (root == 0U) break;
    }
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
  balance->last_resort = balance->failed > 0U;
  balance->round = (balance->round + 1U) & 7U;
  balance->demand_left = 2;
  balance->opened_at = unit->tick_time;
  balance->decide_at = unit->tick_time + DECIDE_TICKS + rs_there_and_back(here);
  if (balance->last_resort) balance->decide_at += DETOUR_TICKS;
  balance->close_at = balance->decide_at + RS_OFFER_TICKS;
  if (balance->failed < 1000U) ++balance->failed; /* until an offer comes */
  for (unsigned i = 0; i < RS_UNIT_GRANTED; ++i) balance->granted[i] = RS_ID_NONE;
}
