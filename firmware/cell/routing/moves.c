/* SPDX-License-Identifier: Apache-2.0
 * Planned moves (R10): a granted cell changes its tree without losing a frame.
 *
 * It cannot simply adopt a neighbour in the other tree, because that must come strictly before its feasible distance.
 * So it stops adopting ticks of its old parent, keeps forwarding through it, and adopts the target at its next tick,
 * which is newer. Feasibility remains the only law, and the old path stays whole until the new one is. */
#include "cell/routing/moves.h"

#include "cell/link/link.h"
#include "cell/routing/parent.h"
#include "cell/routing/refusal.h"
#include "cell/routing/subtree.h"
#include "cell/time/timer.h"
#include "cell/transport/queues.h"
#include "cell/wire/tags.h"
#include "cell/wire/wave.h"

/* The children hear no newer tick while a move is held, and may not take that for a stale way. */
_Static_assert(RS_HOLD_US + RS_TICK_US < RS_STALE_US, "a planned move is over before its children lose patience");

enum { NO_ROUND = 0xFF };  /* numbers of rounds are smaller, and come again: what was told in one holds in that alone */
enum { DETOUR_TICKS = 2 }; /* that a cell at the border waits, and one more for each hop below it */

/* Whether the deepest cell of the subtree would not hang too deep there. More may have joined it since the offer. */
static bool within_cap(const rs_route* route, const rs_neighbour* target, const rs_wave* wave) {
  return target->hops + 1U + route->subtree_height <= wave->depth_cap;
}

static void rest(rs_route* route) {
  route->resting = true;
  route->moved_sequence = route->wave.sequence;
}

/* Begins a move to the neighbour at a port. */
static void begin_handover(rs_cell* cell, unsigned port, uint32_t size, uint32_t now_us) {
  rs_route* route = &cell->route;
  route->handover = true;
  route->handover_size = (uint16_t)size;
  route->target_port = (uint8_t)(port + 1U);
  route->target_root = route->neighbour[port].wave.root;
  route->handover_us = now_us;
}

static void leave(rs_cell* cell, uint32_t target_root, uint32_t now_us) {
  rs_route* route = &cell->route;
  if (route->handover || route->parent_port == RS_NO_PARENT || target_root == route->wave.root) return;
  if (route->told_round != route->demands.round) return;
  unsigned best = RS_PORTS;
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    const rs_neighbour* neighbour = &route->neighbour[port];
    if (port + 1U == route->parent_port || !rs_move_open(route, neighbour)) continue;
    if (neighbour->wave.root != target_root || !within_cap(route, neighbour, &route->wave)) continue;
    if (best == RS_PORTS || neighbour->hops < route->neighbour[best].hops) best = port;
  }
  if (best == RS_PORTS) return;
  begin_handover(cell, best, route->told_size, now_us);
  rs_timer_set(cell, now_us);
}

void rs_move_grant(rs_cell* cell, unsigned port, const uint8_t* frame, uint32_t now_us) {
  rs_route* route = &cell->route;
  rs_grant grant;
  rs_grant_unpack(&grant, frame);
  const uint16_t age = (uint16_t)(route->wave.sequence - grant.sequence + RS_SEQUENCE_WINDOW);
  if (port + 1U != route->parent_port || age > 2U * RS_SEQUENCE_WINDOW || grant.root != route->wave.root) return;
  if (cell->keyed && cell->turn == RS_TURN_NONE) return; /* it cannot tell yet */
  const uint32_t time =
      rs_wave_time(&route->wave) + (uint16_t)(grant.sequence - route->wave.sequence + 0x8000U) - 0x8000U;
  if (cell->keyed && !rs_tags_equal(rs_command_tag(cell->turn_key, frame, time), grant.tag)) {
    rs_refuse_tag(cell, port, now_us);
    return;
  }
  /* Its wants and grants are in force already, or over. */
  const uint16_t before = (uint16_t)(route->demands.sequence - grant.sequence);
  if (route->demands.root == grant.root && before > 0U && before <= 2U * RS_SEQUENCE_WINDOW) return;
  rs_queue_down(cell, frame);
  if (route->demands.root != grant.root || route->demands.round != grant.round) route->told_round = NO_ROUND;
  route->demands = (rs_demands){
      .sequence = (uint16_t)grant.sequence,
      .size = {(uint16_t)grant.demand_1_size, (uint16_t)grant.demand_2_size, (uint16_t)grant.demand_3_size},
      .target = {(uint8_t)grant.demand_1_root, (uint8_t)grant.demand_2_root, (uint8_t)grant.demand_3_root},
      .root = (uint8_t)grant.root,
      .round = (uint8_t)grant.round,
      .open = grant.demand_1_root != 0U,
      .last_resort = (uint8_t)grant.last_resort};
  for (unsigned p = 0; p < RS_PORTS; ++p) {
    rs_offer* offer = &route->neighbour[p].offer;
    if (grant.cell != RS_ID_NONE && offer->cell == grant.cell) offer->cell = RS_ID_NONE;
  }
  if (grant.cell != RS_ID_NONE && grant.cell == cell->id) leave(cell, grant.target_root, now_us);
  rs_subtree_update(cell);
}

bool rs_move_shed(rs_cell* cell, uint32_t now_us) {
  const rs_route* route = &cell->route;
  unsigned best = RS_PORTS;
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    const rs_neighbour* neighbour = &route->neighbour[port];
    if (port + 1U == route->parent_port || neighbour->child || neighbour->draining || !rs_link_usable(neighbour))
      continue;
    if (neighbour->wave.root != route->wave.root || neighbour->hops >= route->hops) continue;
    if (!rs_route_feasible(route, port) || rs_route_runs_ahead(route, neighbour)) continue;
    if (best == RS_PORTS || neighbour->hops < route->neighbour[best].hops) best = port;
  }
  if (best == RS_PORTS) return false;
  rs_route_adopt(cell, best, now_us);
  return true;
}

void rs_move_detour(rs_cell* cell, uint32_t now_us) {
  rs_route* route = &cell->route;
  if (route->handover || route->parent_port == RS_NO_PARENT) return;
  /* A child of a cell that may go a longer way soon says so at once: no deep cell comes below it meanwhile, which that
   * way would bring beyond the cap on the depth. */
  if (route->draining_ticks == 0U && route->neighbour[route->parent_port - 1U].draining) rs_subtree_update(cell);
  if (route->draining_ticks == 0U) return;
  /* The children of this cell have to know it first, so that it does not go to one of them; and they go first, so
   * that it is known how deep its subtree is. */
  if (route->draining_ticks < 255U) ++route->draining_ticks;
  if (route->draining_ticks <= DETOUR_TICKS + route->subtree_height) return;
  const rs_neighbour* parent = &route->neighbour[route->parent_port - 1U];
  /* One hold at a time along a way, or those below lose patience; and few, as each costs a beacon or two. */
  const bool behind = parent->wave.sequence != (uint16_t)(route->wave.sequence + 1U);
  if (!parent->draining || behind || now_us - route->handover_us < RS_DETOUR_PAUSE_US) return;
  unsigned best = RS_PORTS;
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    const rs_neighbour* neighbour = &route->neighbour[port];
    if (port + 1U == route->parent_port || !rs_move_open(route, neighbour)) continue;
    if (neighbour->wave.root != route->wave.root || !within_cap(route, neighbour, &route->wave)) continue;
    if (best == RS_PORTS || neighbour->hops < route->neighbour[best].hops) best = port;
  }
  if (best == RS_PORTS) return;
  begin_handover(cell, best, route->subtree_size, now_us); /* no cell has to know before it is done */
  rs_subtree_update(cell);
  rs_timer_set(cell, now_us);
}

bool rs_move_advance(rs_cell* cell, unsigned port, uint32_t now_us) {
  rs_route* route = &cell->route;
  if (route->handover && port + 1U == route->target_port) {
    const rs_neighbour* target = &route->neighbour[port];
    const bool within = target->hops < RS_HOPS_POISON && within_cap(route, target, &target->wave);
    const bool detour = route->target_root == route->wave.root;
    const bool light = detour || route->subtree_size <= route->handover_size;
    if (target->wave.root != route->target_root || target->draining || !within) {
      route->handover = false;
    } else if (light && rs_route_feasible(route, port)) {
      rs_route_adopt(cell, port, now_us);
      if (detour) return true;
      rest(route);
      return true;
    }
  }
  const unsigned parent = route->parent_port - 1U;
  return parent < RS_PORTS && route->neighbour[parent].draining && rs_move_shed(cell, now_us);
}

void rs_move_check(rs_cell* cell, uint32_t now_us) {
  rs_route* route = &cell->route;
  if (route->handover && now_us - route->handover_us >= rs_move_longest_us(route)) {
    route->handover = false;
    if (route->target_root != route->wave.root) rest(route); /* others may be luckier */
  }
  if ((uint16_t)(route->wave.sequence - route->moved_sequence) >= RS_REST_TICKS) route->resting = false;
}
