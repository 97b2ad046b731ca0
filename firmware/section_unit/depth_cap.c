/* SPDX-License-Identifier: Apache-2.0
 * A tree may grow deeper than it was formed only if there is no other way: the cap on the hops of moved cells starts at
 * the depth of the deepest cell and is raised by one when several rounds have brought no progress. */
#include "section_unit/depth_cap.h"

#include "section_unit/demands.h"
#include "section_unit/trees.h"

enum {
  STEADY_ROUNDS = 3,
  STALLED_ROUNDS = 8 /* without progress, after which the cap is raised */
};

/* Deeper no frame goes, whatever the damaged memory of a cell says. */
static uint8_t within_hops(unsigned depth) {
  return (uint8_t)(depth < RS_TTL_START ? depth : RS_TTL_START - 1U);
}

static void set_cap(rs_section_unit* unit, const rs_trees* trees, unsigned first, uint8_t base, uint8_t cap) {
  for (unsigned k = first; k < trees->count; ++k) {
    if (trees->component[k] != first || trees->port[k] == RS_TREE_FOREIGN) continue;
    rs_unit_balance* balance = &unit->port[trees->port[k]].balance;
    balance->base_depth = base;
    balance->depth_cap = cap;
    balance->stalled = 0;
    balance->failed = 0;
  }
}

/* What the cap counts from once cells have come or gone. Hops that balance has added are no new base, or each coming
 * and going would allow some more. */
static uint8_t base_after(uint8_t base, uint8_t depth) {
  return base != 0U && depth > base && depth <= base + RS_DEPTH_RAISE_MAX ? base : depth;
}

void rs_depth_cap_watch(rs_section_unit* unit, const rs_trees* trees, unsigned first, rs_unit_balance* lead) {
  uint32_t cells = 0, most = 0;
  uint16_t count = 0;
  uint64_t squares = 0;
  uint8_t depth = 0, cap = 0;
  unsigned wanting = 0, failing = 0;
  for (unsigned k = first; k < trees->count; ++k) {
    if (trees->component[k] != first) continue;
    ++count;
    cells += trees->size[k];
    squares += (uint64_t)trees->size[k] * trees->size[k];
    if (trees->size[k] > most) most = trees->size[k];
    if (trees->height[k] > depth) depth = trees->height[k];
    if (trees->depth_cap[k] > cap) cap = trees->depth_cap[k];
    if (trees->port[k] == RS_TREE_FOREIGN) continue;
    const rs_unit_balance* balance = &unit->port[trees->port[k]].balance;
    if (balance->failed == 0U && !balance->open) continue;
    ++wanting;
    if (rs_demands_stuck(balance)) ++failing;
  }
  lead->steady = count != lead->trees || cells != lead->cells ? 0U : lead->steady < 100U ? lead->steady + 1U : 100U;
  lead->trees = count;
  lead->cells = cells;
  if (lead->steady >= STEADY_ROUNDS && (count != lead->base_trees || cells != lead->base_cells)) {
    lead->base_trees = count;
    lead->base_cells = cells;
    lead->best_squares = squares;
    depth = within_hops(depth);
    set_cap(unit, trees, first, base_after(lead->base_depth, depth), depth);
    return;
  }
  if (lead->base_trees == 0U) return;
  const uint8_t deepest = within_hops(lead->base_depth + (unsigned)RS_DEPTH_RAISE_MAX);
  if (cap > lead->depth_cap && cap <= deepest) {
    set_cap(unit, trees, first, lead->base_depth, cap);
    return;
  }
  if (cells != lead->base_cells) return;
  if (squares < lead->best_squares) {
    lead->best_squares = squares;
    lead->stalled = 0;
  } else if (wanting > 0U && lead->stalled < 255U) {
    ++lead->stalled;
  }
  const bool level = most <= (cells + count - 1U) / count;
  if (wanting == 0U || level || lead->depth_cap >= deepest) return;
  if (failing == wanting || lead->stalled >= STALLED_ROUNDS) {
    set_cap(unit, trees, first, lead->base_depth, (uint8_t)(lead->depth_cap + 1U));
  }
}
