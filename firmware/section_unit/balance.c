/* SPDX-License-Identifier: Apache-2.0
 * Levels the trees: each round a port whose tree is too large asks its cells for offers to move to trees that are too
 * small, and grants one of them. Cells go to smaller trees only, and only one move of a tree is under way at a time, so
 * nothing swings. */
#include "section_unit/balance.h"

#include "section_unit/demands.h"
#include "section_unit/depth_cap.h"
#include "section_unit/forming.h"
#include "section_unit/port.h"
#include "section_unit/trees.h"

enum {
  BESIDE_TICKS = 100, /* a tree not seen beside the own one for so long is there no more */
  REPEAT_TICKS = 8,   /* wants that still stand are told again so often */
  WINDOW_TICKS = 64   /* longest round in which anything is granted */
};

/* ---- What is heard of a tree ---- */

static void see_beside(rs_unit_balance* balance, uint8_t root, uint64_t tick) {
  unsigned place = RS_UNIT_BESIDE;
  for (unsigned i = 0; i < RS_UNIT_BESIDE; ++i) {
    if (balance->beside[i] == root) {
      balance->beside_seen[i] = tick;
      return;
    }
    if (balance->beside[i] == 0U) place = i;
  }
  if (place == RS_UNIT_BESIDE) return;
  balance->beside[place] = root;
  balance->beside_seen[place] = tick;
}

void rs_balance_status(rs_section_unit* unit, unsigned port, const rs_status* status) {
  rs_unit_balance* balance = &unit->port[port].balance;
  const uint32_t foreign[RS_FOREIGN_ROOTS] = {status->foreign_1, status->foreign_2, status->foreign_3};
  for (unsigned i = 0; i < RS_FOREIGN_ROOTS; ++i) {
    if (foreign[i] != 0U && foreign[i] != rs_root_of(unit, port)) {
      see_beside(balance, (uint8_t)foreign[i], unit->tick_time);
    }
  }
  balance->offer = (rs_offer){.cell = (uint16_t)status->candidate,
                              .size = (uint16_t)status->candidate_size,
                              .delta = (uint8_t)status->candidate_delta,
                              .root = (uint8_t)status->candidate_root,
                              .round = (uint8_t)status->candidate_round};
}

static void forget_beside(rs_section_unit* unit) {
  for (unsigned port = 0; port < unit->config.ports; ++port) {
    rs_unit_balance* balance = &unit->port[port].balance;
    for (unsigned i = 0; i < RS_UNIT_BESIDE; ++i) {
      if (unit->tick_time - balance->beside_seen[i] > BESIDE_TICKS) balance->beside[i] = 0;
    }
  }
}

uint32_t rs_balance_pack(const rs_section_unit* unit, uint8_t* records, uint64_t now_ns) {
  uint32_t count = 0;
  for (unsigned port = 0; port < unit->config.ports; ++port) {
    const rs_unit_port* here = &unit->port[port];
    if (!rs_port_alive(here, now_ns)) continue;
    rs_peer_tree tree = {.size = here->size,
                         .height = (uint8_t)(here->root ? here->height + 1U : 0U),
                         .depth_cap = here->balance.depth_cap};
    for (unsigned i = 0; i < RS_PEER_NEIGHBOURS; ++i) tree.neighbour[i] = here->balance.beside[i];
    rs_peer_tree_pack(records + RS_DATAGRAM_RECORD_BYTES * count++, port + 1U, &tree);
  }
  return count;
}

/* ---- Grants ---- */

/* A grant frame: the wants as they are now, and leave for a cell to go, if any. */
static void send_grant(rs_section_unit* unit, unsigned port, const rs_offer* offer) {
  const rs_unit_balance* balance = &unit->port[port].balance;
  const rs_grant grant = {.type = RS_TYPE_grant,
                          .sequence = (uint32_t)unit->tick_time & 0xFFFFU,
                          .root = rs_root_of(unit, port),
                          .round = balance->round,
                          .cell = offer->cell,
                          .target_root = offer->cell == RS_ID_NONE ? 0U : offer->root,
                          .last_resort = balance->last_resort,
                          .demand_1_root = balance->demand_root[0],
                          .demand_1_size = balance->demand_size[0],
                          .demand_2_root = balance->demand_root[1],
                          .demand_2_size = balance->demand_size[1],
                          .demand_3_root = balance->demand_root[2],
                          .demand_3_size = balance->demand_size[2]};
  uint8_t content[RS_CONTENT_BYTES];
  rs_grant_pack(content, &grant);
  rs_ports_send(unit, port, content);
}

/* By how much fewer cells tree `root` has than the own one, with what it was granted in this round: no more may go
 * there, or it would become fuller than what it takes from. */
static uint32_t gap_left(const rs_unit_balance* balance, uint8_t root) {
  uint32_t gap = 0, gone = 0;
  for (unsigned w = 0; w < RS_DEMANDS; ++w) {
    const bool there = balance->given_root[w] == root;
    if (there) gap = balance->gap[w];
    gone += (there ? 2U : 1U) * balance->given[w];
  }
  return gap > gone ? gap - gone : 0U;
}

/* Cells of a tree as they are known now. */
static uint32_t size_of(const rs_section_unit* unit, uint8_t root) {
  const unsigned u = rs_unit_of_root(root), port = rs_port_of_root(root);
  if (root == 0U || port >= RS_SECTION_UNIT_PORTS_MAX) return 0;
  return u == unit->config.unit ? unit->port[port].size : unit->peer[u].tree[port].size;
}

/* Whether the last offer is one of this round, not yet granted, that fits what is still wanted; and still fits, if
 * other trees have changed since: then it waits. */
static bool fits(const rs_section_unit* unit, unsigned port) {
  const rs_unit_balance* balance = &unit->port[port].balance;
  const rs_offer* offer = &balance->offer;
  if (offer->cell == RS_ID_NONE || offer->size == 0U || offer->round != balance->round) return false;
  for (unsigned i = 0; i < RS_UNIT_GRANTED; ++i) {
    if (balance->granted[i] == offer->cell) return false;
  }
  uint32_t taken = size_of(unit, offer->root);
  /* Other ports did not reckon with the wants of one that found no offer for long. */
  if (rs_demands_stuck(balance)) taken += rs_demands_given(unit, port, offer->root);
  if (taken + offer->size > unit->port[port].size) return false;
  for (unsigned w = 0; w < RS_DEMANDS; ++w) {
    if (balance->demand_root[w] == offer->root && balance->demand_size[w] >= offer->size) return true;
  }
  return false;
}

/* What is wanted still leaves no tree fuller than the own one. */
static void give(rs_unit_balance* balance) {
  const rs_offer* offer = &balance->offer;
  for (unsigned w = 0; w < RS_DEMANDS; ++w) {
    if (balance->given_root[w] == offer->root) balance->given[w] = (uint16_t)(balance->given[w] + offer->size);
    if (balance->demand_root[w] == offer->root) {
      balance->demand_size[w] = (uint16_t)(balance->demand_size[w] - offer->size);
    }
  }
  for (unsigned w = RS_DEMANDS; w-- > 0U;) {
    const uint32_t left = gap_left(balance, balance->demand_root[w]);
    if (balance->demand_size[w] > left) balance->demand_size[w] = (uint16_t)left;
    if (balance->demand_size[w] == 0U) rs_demand_remove(balance, w);
  }
  balance->granted[balance->granted_next++ % RS_UNIT_GRANTED] = offer->cell;
}

static void serve(rs_section_unit* unit, unsigned port) {
  rs_unit_port* here = &unit->port[port];
  rs_unit_balance* balance = &here->balance;
  static const rs_offer no_offer = {.cell = RS_ID_NONE};
  const uint64_t tick = unit->tick_time;
  if (!balance->open) return;
  if (!here->root) {
    rs_demands_close(balance);
    balance->open = false;
    return;
  }
  if (tick >= balance->decide_at && fits(unit, port)) {
    give(balance);
    send_grant(unit, port, &balance->offer);
    balance->offer.cell = RS_ID_NONE;
    balance->decide_at = tick + RS_GRANT_TICKS;
    balance->close_at = tick + RS_OFFER_TICKS + rs_there_and_back(here);
    balance->failed = 0;
    ++unit->grants;
  } else if (balance->demand_left > 0U || (tick - balance->opened_at) % REPEAT_TICKS == 0U) {
    if (balance->demand_left > 0U) --balance->demand_left;
    send_grant(unit, port, &no_offer);
  }
  const bool too_long = balance->failed == 0U && tick >= balance->opened_at + WINDOW_TICKS;
  if (balance->demand_root[0] != 0U && tick < balance->close_at && !too_long) return;
  /* Now the sizes have to settle before anything new is wanted. */
  rs_demands_close(balance);
  balance->open = false;
  send_grant(unit, port, &no_offer);
  balance->busy_until = tick + (balance->failed > 0U ? 0U : RS_SETTLE_TICKS + rs_there_and_back(here));
}

static void start_round(rs_section_unit* unit, uint64_t now_ns) {
  forget_beside(unit);
  rs_trees trees;
  rs_trees_gather(&trees, unit, now_ns);
  for (unsigned first = 0; first < trees.count; ++first) {
    if (trees.component[first] != first) continue;
    unsigned lead = RS_TREE_FOREIGN; /* port that keeps the component's record */
    for (unsigned k = first; k < trees.count; ++k) {
      if (trees.component[k] != first || trees.port[k] == RS_TREE_FOREIGN) continue;
      if (lead == RS_TREE_FOREIGN) lead = trees.port[k];
      const rs_unit_port* here = &unit->port[trees.port[k]];
      if (here->root && here->balance.depth_cap > 0U && !here->balance.open &&
          unit->tick_time >= here->balance.busy_until) {
        rs_demands_start(unit, &trees, k);
      }
    }
    if (lead != RS_TREE_FOREIGN) rs_depth_cap_watch(unit, &trees, first, &unit->port[lead].balance);
  }
}

void rs_balance_tick(rs_section_unit* unit, uint64_t now_ns) {
  rs_forming_tick(unit, now_ns);
  if (unit->forming) return;
  if (unit->tick_time % RS_BALANCE_TICKS == 0U) start_round(unit, now_ns);
  for (unsigned port = 0; port < unit->config.ports; ++port) serve(unit, port);
}
