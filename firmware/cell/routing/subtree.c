/* SPDX-License-Identifier: Apache-2.0
 * What a cell tells its parent of its subtree: how many cells, how deep, which other trees are beside it, and which
 * cell could best move to one. */
#include "cell/routing/subtree.h"

#include "cell/link/link.h"
#include "cell/routing/offers.h"
#include "cell/time/spread.h"
#include "cell/transport/queues.h"
#include "robotskin/crc.h"

/* Roots seen, each once. */
typedef struct {
  uint8_t root[RS_PORTS * RS_FOREIGN_ROOTS];
  unsigned count;
} root_set;

static void add_root(root_set* set, uint8_t root) {
  if (root == 0U) return;
  for (unsigned i = 0; i < set->count; ++i) {
    if (set->root[i] == root) return;
  }
  set->root[set->count++] = root;
}

/* All of them, or as many as there is room for, in turn. */
static void report_roots(rs_route* route, const root_set* set) {
  unsigned at = 0;
  if (set->count > RS_FOREIGN_ROOTS) {
    if (++route->foreign_turn >= set->count) route->foreign_turn = 0;
    at = route->foreign_turn;
  }
  for (unsigned i = 0; i < RS_FOREIGN_ROOTS; ++i) {
    route->foreign[i] = i < set->count ? set->root[at] : 0U;
    if (++at >= set->count) at = 0;
  }
}

static bool offers_equal(const rs_offer* a, const rs_offer* b) {
  return a->cell == b->cell && a->size == b->size && a->delta == b->delta && a->root == b->root && a->round == b->round;
}

/* Cells that may hang on one at the border that lets them go, in the first rounds. */
enum { MOST_IN_TURNS = 48, MOST_AT_ONCE = 12 };

/* Where all of a tree hangs on cells at the border, none has anywhere to go while all of them let go. So in six of
 * eight rounds only one in eight of them does. */
static bool in_turns(const rs_demands* demands) {
  return (demands->round & 6U) != 0U;
}

/* Up to so many cells may hang on a cell at the border that lets them go, by round: trunks become light from their ends
 * upwards, and the ways of all others stay as they are. Where few let go at a time, a trunk may be most of its tree. */
static uint32_t most_to_let_go(const rs_demands* demands) {
  return (uint32_t)(in_turns(demands) ? MOST_IN_TURNS : MOST_AT_ONCE) << 2U * (demands->round & 1U);
}

/* Whose turn it is changes every 32 ticks. Neighbours have consecutive ids as a rule; their turns are far apart, so
 * that a trunk is let go of at one place. */
static bool takes_turn(const rs_cell* cell) {
  const rs_demands* demands = &cell->route.demands;
  return !in_turns(demands) || (cell->id * (uint32_t)RS_GOLDEN_FRACTION >> 7U & 7U) == (demands->sequence >> 5U & 7U);
}

/* Whether this cell is beside a tree that shall grow, or hangs on one that is. A trunk along a border can move only
 * with all that hangs on it; cells with another parent off the border go there, and the trunk becomes light. */
static bool hangs_at_border(const rs_cell* cell) {
  const rs_route* route = &cell->route;
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    const rs_neighbour* neighbour = &route->neighbour[port];
    if (neighbour->child || !rs_link_usable(neighbour) || neighbour->hops >= RS_HOPS_POISON) continue;
    if (port + 1U == route->parent_port) {
      if (neighbour->draining) return true;
      continue;
    }
    for (unsigned w = 0; w < RS_DEMANDS; ++w) {
      if (route->demands.target[w] == neighbour->wave.root && takes_turn(cell)) return true;
    }
  }
  return false;
}

static void set_size(rs_neighbour* neighbour, uint32_t size) {
  neighbour->size = (uint16_t)size;
  neighbour->size_complement = (uint16_t)~size;
}

void rs_subtree_update(rs_cell* cell) {
  rs_route* route = &cell->route;
  const bool wanted = rs_demands_open(route);
  uint32_t size = 1, height = 0;
  root_set foreign = {.count = 0};
  rs_offer best = {.cell = RS_ID_NONE};
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    rs_neighbour* neighbour = &route->neighbour[port];
    if (port + 1U == route->parent_port) continue;
    if (neighbour->child && neighbour->up) {
      if (neighbour->lagging) continue;
      if ((neighbour->size ^ neighbour->size_complement) != 0xFFFF) rs_subtree_forget(neighbour);
      size += neighbour->size;
      if (neighbour->height >= height) height = neighbour->height + 1U;
      for (unsigned i = 0; i < RS_FOREIGN_ROOTS; ++i) {
        if (neighbour->foreign[i] != route->wave.root) add_root(&foreign, neighbour->foreign[i]);
      }
      if (wanted) rs_offer_better(route, &neighbour->offer, &best);
    } else if (rs_link_usable(neighbour) && neighbour->hops < RS_HOPS_POISON) {
      if (neighbour->wave.root != route->wave.root) add_root(&foreign, neighbour->wave.root);
    }
  }
  if (size > 0xFFFFU) size = 0xFFFFU;
  if (height > 0xFFU) height = 0xFFU;
  if (size != route->subtree_size || height != route->subtree_height) {
    cell->queues.status_due = cell->queues.size_due = true;
    rs_queues_throttle(cell, route->subtree_size, size);
  }
  route->subtree_size = (uint16_t)size;
  route->subtree_height = (uint8_t)height;
  const bool may_yield =
      wanted && route->demands.last_resort && route->hops > 1U && size <= most_to_let_go(&route->demands);
  if (!may_yield || !hangs_at_border(cell)) {
    route->draining_ticks = 0;
  } else if (route->draining_ticks == 0U) {
    route->draining_ticks = 1;
  }
  if (wanted) rs_offer_own(cell, &best);
  if (!offers_equal(&best, &route->offer)) cell->queues.status_due = true;
  route->offer = best;
  report_roots(route, &foreign);
}

void rs_subtree_forget(rs_neighbour* neighbour) {
  set_size(neighbour, 1);
  neighbour->height = 0;
  neighbour->offer = (rs_offer){.cell = RS_ID_NONE};
  for (unsigned i = 0; i < RS_FOREIGN_ROOTS; ++i) neighbour->foreign[i] = 0;
}

void rs_subtree_status(rs_cell* cell, unsigned port, const uint8_t* frame) {
  rs_neighbour* neighbour = &cell->route.neighbour[port];
  rs_status status;
  rs_status_unpack(&status, frame);
  set_size(neighbour, status.size);
  neighbour->height = (uint8_t)status.height;
  neighbour->foreign[0] = (uint8_t)status.foreign_1;
  neighbour->foreign[1] = (uint8_t)status.foreign_2;
  neighbour->foreign[2] = (uint8_t)status.foreign_3;
  neighbour->offer = (rs_offer){.cell = (uint16_t)status.candidate,
                                .size = (uint16_t)status.candidate_size,
                                .delta = (uint8_t)status.candidate_delta,
                                .root = (uint8_t)status.candidate_root,
                                .round = (uint8_t)status.candidate_round};
  rs_subtree_update(cell);
}

void rs_subtree_pack(rs_cell* cell, uint8_t* frame) {
  rs_subtree_update(cell);
  cell->queues.status_due = cell->queues.size_due = false;
  rs_route* route = &cell->route;
  if (route->offer.cell == cell->id && cell->id != RS_ID_NONE) {
    if (route->told_round != route->offer.round || route->offer.size < route->told_size) {
      route->told_size = route->offer.size;
    }
    route->told_round = route->offer.round;
  }
  const rs_status status = {.type = RS_TYPE_status,
                            .sender = cell->id,
                            .size = route->subtree_size,
                            .height = route->subtree_height,
                            .candidate = route->offer.cell,
                            .candidate_size = route->offer.size,
                            .candidate_delta = route->offer.delta,
                            .candidate_root = route->offer.root,
                            .candidate_round = route->offer.round,
                            .foreign_1 = route->foreign[0],
                            .foreign_2 = route->foreign[1],
                            .foreign_3 = route->foreign[2]};
  rs_status_pack(frame, &status);
  rs_frame_seal(frame);
}
