/* Levels the trees: each round a port whose tree is too large asks its cells for offers to move to trees that are too
 * small, and grants one of them. Only the flows of trees.c make a port want to give, and only one move of a tree is
 * under way at a time, so nothing swings.
 *
 * A tree may grow deeper than it was formed only if there is no other way: the cap on the hops of moved cells starts at
 * the depth of the deepest cell and is raised by one when several rounds have brought no progress. */
#include "section_unit/unit_parts.h"

enum {
  BESIDE_TICKS = 100, /* a tree not seen beside the own one for so long is there no more */
  DECIDE_TICKS = 2,   /* offers are collected so long, and while the tree is crossed */
  OFFER_TICKS = 3,    /* without a further offer, and while the tree is crossed, a round is over */
  DETOUR_TICKS = 10,  /* in a last resort so much longer, until trunks at the border have become light */
  REPEAT_TICKS = 8,   /* wants that still stand are told again so often */
  WINDOW_TICKS = 64,  /* longest round */
  FAILED_ROUNDS = 2,
  STALLED_ROUNDS = 8,
  STEADY_ROUNDS = 3,
  FLOW_LEAST = RS_POTENTIAL_SCALE / 50,
  FLOW_WHOLE = RS_POTENTIAL_SCALE * 15 / 16
};

/* ---- Forming ---- */

static void watch_forming(rs_section_unit* unit, uint64_t now_ns) {
  const uint64_t tick = unit->tick_time;
  uint32_t cells = 0;
  for (unsigned port = 0; port < unit->config.ports; ++port) cells += unit->port[port].size;
  bool others = false, others_formed = false;
  for (unsigned u = 0; u < RS_UNITS_MAX; ++u) {
    const rs_unit_peer* peer = &unit->peer[u];
    if (!rs_peer_counts(peer, now_ns) || (peer->flags & RS_PEER_STARTING) != 0) continue;
    for (unsigned port = 0; port < RS_SECTION_UNIT_PORTS_MAX; ++port) {
      if ((peer->ports >> port & 1U) != 0U && peer->tree[port].size > 0U) others = true;
    }
    if ((peer->flags & RS_PEER_FORMING) == 0) others_formed = true;
  }
  if (cells != unit->cells) {
    if (unit->cells == 0U) unit->forming_since = tick;
    unit->cells = cells;
    unit->cells_since = tick;
  }
  if (unit->forming) {
    const bool formed = cells > 0U && tick - unit->cells_since >= RS_FORMING_TICKS &&
                        tick - unit->forming_since >= RS_FORMING_MIN_TICKS;
    unit->forming = !(formed || (others && others_formed));
  } else if (cells == 0U && !others && tick - unit->cells_since >= RS_FORMING_TICKS) {
    unit->forming = true;
    for (unsigned port = 0; port < unit->config.ports; ++port) unit->port[port].balance = (rs_unit_balance){.round = 0};
  }
}

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
                              .round = (uint8_t)status->candidate_round,
                              .whole = (uint8_t)status->candidate_whole};
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

/* ---- Wants and grants ---- */

/* Down and up a tree so deep takes about so many ticks. */
static uint64_t there_and_back(const rs_unit_port* port) {
  return (3U * (uint32_t)port->height) / 8U;
}

/* A grant frame: the wants as they are now, and leave for a cell to go, if any. */
static void send_grant(rs_section_unit* unit, unsigned port, const rs_offer* offer) {
  const rs_unit_balance* balance = &unit->port[port].balance;
  const rs_grant grant = {.type = RS_TYPE_grant,
                          .sequence = (uint32_t)unit->tick_time & 0xFFFFU,
                          .root = rs_root_of(unit, port),
                          .round = balance->round,
                          .cell = offer->cell,
                          .target_root = offer->cell == RS_ID_NONE ? 0U : offer->root,
                          .whole = offer->cell == RS_ID_NONE ? 0U : offer->whole,
                          .last_resort = balance->last_resort,
                          .want_1_root = balance->want_root[0],
                          .want_1_size = balance->want_size[0],
                          .want_2_root = balance->want_root[1],
                          .want_2_size = balance->want_size[1],
                          .want_3_root = balance->want_root[2],
                          .want_3_size = balance->want_size[2]};
  uint8_t content[RS_CONTENT_BYTES];
  rs_grant_pack(content, &grant);
  rs_ports_send(unit, port, content);
}

/* By how much fewer cells tree `root` has than the own one, with what it was granted in this round: no more may go
 * there, or it would become fuller than what it takes from. */
static uint32_t gap_left(const rs_unit_balance* balance, uint8_t root) {
  uint32_t gap = 0, gone = 0;
  for (unsigned w = 0; w < RS_WANTS; ++w) {
    const bool there = balance->given_root[w] == root;
    if (there) gap = balance->gap[w];
    gone += (there ? 2U : 1U) * balance->given[w];
  }
  return gap > gone ? gap - gone : 0U;
}

static void remove_want(rs_unit_balance* balance, unsigned w) {
  for (; w + 1U < RS_WANTS; ++w) {
    balance->want_root[w] = balance->want_root[w + 1U];
    balance->want_size[w] = balance->want_size[w + 1U];
  }
  balance->want_root[w] = 0;
  balance->want_size[w] = 0;
}

static void close_wants(rs_unit_balance* balance) {
  for (unsigned w = 0; w < RS_WANTS; ++w) remove_want(balance, 0);
}

/* Cells of a tree as they are known now. */
static uint32_t size_of(const rs_section_unit* unit, uint8_t root) {
  const unsigned u = root >> 4, port = (root & 15U) - 1U;
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
  if (size_of(unit, offer->root) + offer->size > unit->port[port].size) return false;
  for (unsigned w = 0; w < RS_WANTS; ++w) {
    if (balance->want_root[w] == offer->root && balance->want_size[w] >= offer->size) return true;
  }
  return false;
}

/* What is wanted still leaves no tree fuller than the own one. */
static void give(rs_unit_balance* balance) {
  const rs_offer* offer = &balance->offer;
  for (unsigned w = 0; w < RS_WANTS; ++w) {
    if (balance->given_root[w] == offer->root) balance->given[w] = (uint16_t)(balance->given[w] + offer->size);
    if (balance->want_root[w] == offer->root) {
      balance->want_size[w] = (uint16_t)(balance->want_size[w] - offer->size);
    }
  }
  for (unsigned w = RS_WANTS; w-- > 0U;) {
    const uint32_t left = gap_left(balance, balance->want_root[w]);
    if (balance->want_size[w] > left) balance->want_size[w] = (uint16_t)left;
    if (balance->want_size[w] == 0U) remove_want(balance, w);
  }
  balance->granted[balance->granted_next++ % RS_UNIT_GRANTED] = offer->cell;
}

static void serve(rs_section_unit* unit, unsigned port) {
  rs_unit_port* here = &unit->port[port];
  rs_unit_balance* balance = &here->balance;
  static const rs_offer nobody = {.cell = RS_ID_NONE};
  const uint64_t tick = unit->tick_time;
  if (!balance->open) return;
  if (!here->root) {
    close_wants(balance);
    balance->open = false;
    return;
  }
  if (tick >= balance->decide_at && fits(unit, port)) {
    give(balance);
    send_grant(unit, port, &balance->offer);
    balance->offer.cell = RS_ID_NONE;
    balance->decide_at = tick + RS_GRANT_TICKS;
    balance->close_at = tick + OFFER_TICKS + there_and_back(here);
    balance->failed = 0;
    ++unit->grants;
  } else if (balance->want_left > 0U || (tick - balance->opened_at) % REPEAT_TICKS == 0U) {
    if (balance->want_left > 0U) --balance->want_left;
    send_grant(unit, port, &nobody);
  }
  if (balance->want_root[0] != 0U && tick < balance->close_at && tick < balance->opened_at + WINDOW_TICKS) return;
  /* Now the sizes have to settle before anything new is wanted. */
  close_wants(balance);
  balance->open = false;
  send_grant(unit, port, &nobody);
  balance->busy_until = tick + (balance->failed > 0U ? 0U : RS_SETTLE_TICKS + there_and_back(here));
}

/* By how many cells tree j is smaller than tree k, with what other ports are giving it already. Cells go downhill only,
 * and so many at most: no cable becomes fuller than the one that gives, and loads no less even, whatever becomes of
 * what j is to pass on. */
static uint32_t gap_to(const rs_section_unit* unit, const rs_trees* trees, unsigned k, unsigned j) {
  uint32_t taken = trees->size[j];
  for (unsigned port = 0; port < unit->config.ports; ++port) {
    const rs_unit_balance* other = &unit->port[port].balance;
    if (port == trees->port[k]) continue;
    for (unsigned w = 0; w < RS_WANTS; ++w) {
      if (other->open && other->want_root[w] == trees->root[j]) taken += other->want_size[w];
      const bool counts = other->open || unit->tick_time < other->busy_until;
      if (counts && other->given_root[w] == trees->root[j]) taken += other->given[w];
    }
  }
  return trees->size[k] > taken ? trees->size[k] - taken : 0U;
}

/* How much of that tree j may take. One that does not pass cells on takes no more than brings the two level, because
 * what it takes beyond that stays there. */
static uint32_t room(const rs_section_unit* unit, const rs_trees* trees, unsigned j, uint32_t gap) {
  const bool stuck = trees->port[j] != RS_TREE_FOREIGN && unit->port[trees->port[j]].balance.failed > FAILED_ROUNDS;
  return stuck ? gap / 2U : gap;
}

/* What a tree gives to its neighbours: the flows that are worth a move, largest first. */
static void want(rs_section_unit* unit, const rs_trees* trees, unsigned k, uint32_t cells, uint32_t count,
                 const rs_unit_balance* lead) {
  const uint32_t mean = cells / count, ideal = (cells + count - 1U) / count;
  rs_unit_port* here = &unit->port[trees->port[k]];
  rs_unit_balance* balance = &here->balance;
  /* If nobody offers where the flow is, a round about way may do; for a while. */
  const bool desperate = balance->failed >= FAILED_ROUNDS && lead->stalled < 4U * STALLED_ROUNDS;
  close_wants(balance);
  int64_t taken[RS_WANTS] = {0, 0, 0};
  const uint32_t excess = trees->size[k] > mean ? trees->size[k] - mean : 1U;
  for (unsigned j = 0; j < trees->count; ++j) {
    if (!rs_trees_beside(trees, k, j)) continue;
    int64_t flow = unit->potential[trees->root[k]] - unit->potential[trees->root[j]];
    const int64_t whole = (flow + RS_POTENTIAL_SCALE / 2) / RS_POTENTIAL_SCALE;
    /* A flow of less than a cell is worth a move only if it levels, or if the tree is too large: not from 11 to 10. */
    const bool levels = trees->size[k] > trees->size[j] + 1U || (desperate && trees->size[k] > ideal);
    if (flow <= FLOW_LEAST || (!levels && (whole < 1 || (flow < FLOW_WHOLE && trees->size[k] <= ideal)))) continue;
    uint32_t size = whole < 1 ? 1U : whole > 2047 ? 2047U : (uint32_t)whole;
    /* Never more than the own excess, unless that still levels; all that levels, if nobody offered less. */
    const uint32_t levelling = trees->size[k] > trees->size[j] + 1U ? trees->size[k] - trees->size[j] - 1U : 1U;
    if (size > excess && size > levelling) size = excess > levelling ? excess : levelling;
    if (balance->failed > 0U && levelling > size) size = levelling > 2047U ? 2047U : levelling;
    uint32_t gap = gap_to(unit, trees, k, j);
    const uint32_t most_taken = room(unit, trees, j, gap);
    if (most_taken == 0U) continue;
    if (size > most_taken) size = most_taken;
    uint8_t root = trees->root[j];
    for (unsigned w = 0; w < RS_WANTS; ++w) {
      if (balance->want_root[w] != 0U && taken[w] >= flow) continue;
      const int64_t other_flow = taken[w];
      const uint8_t other_root = balance->want_root[w];
      const uint16_t other_size = balance->want_size[w], other_gap = balance->gap[w];
      taken[w] = flow;
      balance->want_root[w] = root;
      balance->want_size[w] = (uint16_t)size;
      balance->gap[w] = (uint16_t)gap;
      flow = other_flow;
      root = other_root;
      size = other_size;
      gap = other_gap;
      if (root == 0U) break;
    }
  }
  if (balance->want_root[0] == 0U) {
    balance->failed = 0;
    return;
  }
  for (unsigned w = 0; w < RS_WANTS; ++w) {
    balance->given_root[w] = balance->want_root[w];
    balance->given[w] = 0;
  }
  balance->open = true;
  balance->last_resort = balance->failed > 0U;
  balance->round = (balance->round + 1U) & 7U;
  balance->want_left = 2;
  balance->opened_at = unit->tick_time;
  balance->decide_at = unit->tick_time + DECIDE_TICKS + there_and_back(here);
  if (balance->last_resort) balance->decide_at += DETOUR_TICKS;
  balance->close_at = balance->decide_at + OFFER_TICKS;
  if (balance->failed < 1000U) ++balance->failed; /* until an offer comes */
  for (unsigned i = 0; i < RS_UNIT_GRANTED; ++i) balance->granted[i] = RS_ID_NONE;
}

/* ---- The depth cap ---- */

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

/* How deep balance may bring the cells of a component: some hops deeper than the deepest cell of the skin was formed,
 * as it is that one which is heard last. Of other units' components it is known only how deep they are. */
static uint8_t deepest_allowed(const rs_section_unit* unit, const rs_trees* trees, unsigned first, uint8_t base) {
  unsigned deepest = base + RS_DEPTH_RAISE_MAX;
  for (unsigned k = 0; k < trees->count; ++k) {
    if (trees->component[k] == first || trees->size[k] == 0U) continue;
    const bool own = trees->port[k] != RS_TREE_FOREIGN;
    const unsigned there =
        own ? unit->port[trees->port[k]].balance.base_depth + (unsigned)RS_DEPTH_RAISE_MAX : trees->height[k];
    if (there > deepest) deepest = there;
  }
  return (uint8_t)(deepest < RS_TTL_START ? deepest : RS_TTL_START - 1U);
}

/* Sees whether a component with own trees has come nearer to level, and raises its cap if it has not for long. `lead`
 * is the port that keeps its record. */
static void watch_progress(rs_section_unit* unit, const rs_trees* trees, unsigned first, rs_unit_balance* lead) {
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
    if (balance->failed > FAILED_ROUNDS) ++failing;
  }
  lead->steady = count != lead->trees || cells != lead->cells ? 0U : lead->steady < 100U ? lead->steady + 1U : 100U;
  lead->trees = count;
  lead->cells = cells;
  if (lead->steady >= STEADY_ROUNDS && (count != lead->base_trees || cells != lead->base_cells)) {
    lead->base_trees = count;
    lead->base_cells = cells;
    lead->best_squares = squares;
    set_cap(unit, trees, first, depth, depth);
    return;
  }
  if (lead->base_trees == 0U) return;
  const uint8_t deepest = deepest_allowed(unit, trees, first, lead->base_depth);
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

static void start_round(rs_section_unit* unit, uint64_t now_ns) {
  forget_beside(unit);
  rs_trees trees;
  rs_trees_gather(&trees, unit, now_ns);
  rs_trees_relax(&trees, unit->potential);
  for (unsigned first = 0; first < trees.count; ++first) {
    if (trees.component[first] != first) continue;
    uint32_t cells = 0, count = 0;
    unsigned lead = RS_TREE_FOREIGN;
    for (unsigned k = first; k < trees.count; ++k) {
      if (trees.component[k] != first) continue;
      cells += trees.size[k];
      ++count;
      if (lead == RS_TREE_FOREIGN) lead = trees.port[k];
    }
    if (lead == RS_TREE_FOREIGN) continue;
    for (unsigned k = first; k < trees.count; ++k) {
      if (trees.component[k] != first || trees.port[k] == RS_TREE_FOREIGN) continue;
      const rs_unit_port* here = &unit->port[trees.port[k]];
      if (here->root && here->balance.depth_cap > 0U && !here->balance.open &&
          unit->tick_time >= here->balance.busy_until) {
        want(unit, &trees, k, cells, count, &unit->port[lead].balance);
      }
    }
    watch_progress(unit, &trees, first, &unit->port[lead].balance);
  }
}

void rs_balance_tick(rs_section_unit* unit, uint64_t now_ns) {
  watch_forming(unit, now_ns);
  if (unit->forming) return;
  if (unit->tick_time % RS_BALANCE_TICKS == 0U) start_round(unit, now_ns);
  for (unsigned port = 0; port < unit->config.ports; ++port) serve(unit, port);
}
