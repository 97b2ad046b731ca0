/* SPDX-License-Identifier: Apache-2.0
 * What a cell does about its parent when a tick has come and when time has passed (R4, R6 to R9). */
#include "cell/routing/route.h"

#include <stddef.h>

#include "cell/link/link.h"
#include "cell/memory/known_time.h"
#include "cell/memory/turn.h"
#include "cell/routing/links.h"
#include "cell/routing/moves.h"
#include "cell/routing/parent.h"
#include "cell/wire/wave.h"
#include "robotskin/feasibility.h"

static rs_neighbour* parent_of(rs_route* route) {
  return route->parent_port == RS_NO_PARENT ? NULL : &route->neighbour[(route->parent_port - 1U) % RS_PORTS];
}

/* R4 */
static void tick_of_parent(rs_cell* cell, unsigned port, uint32_t now_us) {
  rs_route* route = &cell->route;
  const rs_neighbour* parent = &route->neighbour[port];
  rs_route_heal_distance(route);
  if (parent->child || parent->hops >= RS_HOPS_MAX) {
    rs_route_lose(cell, now_us);
  } else if (parent->draining && rs_move_shed(cell, now_us)) {
    return;
  } else if (rs_newer(parent->wave.sequence, route->wave.sequence)) {
    rs_move_check(cell, now_us);
    rs_move_detour(cell, now_us);
    if (!route->handover) rs_route_adopt(cell, port, now_us);
  } else if (parent->wave.sequence != route->wave.sequence) {
    rs_route_lose(cell, now_us);
  } else if (parent->hops + 1U != route->hops || parent->wave.root != route->wave.root) {
    if (rs_route_feasible(route, port)) {
      rs_route_adopt(cell, port, now_us);
    } else {
      rs_route_lose(cell, now_us);
    }
  }
}

/* R6, R7, R9 and R10 */
static void tick_of_other(rs_cell* cell, unsigned port, uint32_t now_us) {
  rs_route* route = &cell->route;
  const rs_neighbour* neighbour = &route->neighbour[port];
  if (neighbour->child || rs_move_advance(cell, port, now_us) || !rs_route_feasible(route, port)) return;
  if (route->parent_port == RS_NO_PARENT) {
    rs_route_adopt(cell, port, now_us);
    return;
  }
  const int gain = (int)route->hops - (int)neighbour->hops - 1;
  const bool same = neighbour->wave.root == route->wave.root;
  const bool too_deep = route->hops > route->wave.depth_cap;
  const int wanted = same || too_deep ? 1 : (int)route->wave.gain_threshold;
  /* No cell goes back to one at the border while it is to become light, but for being too deep. */
  const bool back = same && neighbour->draining && !route->neighbour[route->parent_port - 1U].draining &&
                    route->hops + route->subtree_height <= route->wave.depth_cap;
  const bool lossy = rs_link_lossy(neighbour, now_us);
  const bool parent_lossy = rs_link_lossy(&route->neighbour[route->parent_port - 1U], now_us);
  if (parent_lossy && !lossy && same) {
    rs_route_adopt(cell, port, now_us);
    return;
  }
  if (gain >= 1 && gain >= wanted && !back && (parent_lossy || !lossy)) {
    rs_route_adopt(cell, port, now_us);
    return;
  }
  const uint16_t ahead = (uint16_t)(neighbour->wave.sequence - route->wave.sequence);
  if (now_us - route->advanced_us > RS_STALE_US && ahead >= RS_STALE_TICKS && ahead < 0x8000U) {
    rs_route_adopt(cell, port, now_us);
  }
}

void rs_route_turn(rs_cell* cell, unsigned port, uint32_t now_us) {
  rs_route* route = &cell->route;
  const rs_neighbour* neighbour = &route->neighbour[port];
  if (route->in_quarantine) return;
  if (!rs_link_usable(neighbour)) {
    if (port + 1U == route->parent_port && neighbour->up) rs_route_lose(cell, now_us);
    return;
  }
  if (port + 1U == route->parent_port) {
    tick_of_parent(cell, port, now_us);
  } else {
    tick_of_other(cell, port, now_us);
  }
  /* Only of a wave that has just come is it certain that a root made it: what is known of neighbours may be damaged. */
  if (route->parent_port == port + 1U && neighbour->hops != RS_HOPS_POISON &&
      rs_waves_equal(&route->wave, &neighbour->wave)) {
    rs_turn_follow(cell, rs_wave_time(&route->wave));
    rs_time_learn(route, rs_wave_time(&route->wave));
  }
}

void rs_route_check(rs_cell* cell, uint32_t now_us) {
  rs_route* route = &cell->route;
  rs_route_heal_distance(route);
  /* Without a parent there is no way to announce, and with one there is. */
  if (route->parent_port == RS_NO_PARENT && route->hops != RS_HOPS_POISON) {
    route->hops = RS_HOPS_POISON;
    rs_route_beacon(cell, now_us);
  }
  if (route->parent_port != RS_NO_PARENT && (route->hops == 0U || route->hops == RS_HOPS_POISON || route->unbound)) {
    rs_route_lose(cell, now_us);
  }
  if (route->in_quarantine) {
    const uint32_t left_us = route->quarantine_us - now_us;
    if (route->parent_port != RS_NO_PARENT || left_us == 0U || left_us > RS_QUARANTINE_US) route->in_quarantine = false;
  }
  rs_links_check(cell, now_us);
  const bool held = route->handover;
  rs_move_check(cell, now_us);

  const rs_neighbour* parent = parent_of(route);
  if (parent != NULL) {
    const bool stale = now_us - route->advanced_us >= RS_STALE_LIMIT_US && !rs_link_lossy(parent, now_us);
    if (!rs_link_usable(parent) || stale) {
      rs_route_lose(cell, now_us);
    } else if (held && !route->handover && rs_newer(parent->wave.sequence, route->wave.sequence) &&
               !rs_route_runs_ahead(route, parent)) {
      tick_of_parent(cell, route->parent_port - 1U, now_us); /* what was held back */
    }
  } else if (!route->in_quarantine) {
    const unsigned best = rs_route_best_feasible(route, now_us);
    if (best < RS_PORTS) {
      rs_route_adopt(cell, best, now_us);
    } else if (now_us - route->orphaned_us >= RS_ORPHAN_RESET_US) {
      /* This cell has no child, so it may forget how near it was. */
      bool alone = true;
      for (unsigned port = 0; port < RS_PORTS; ++port) alone = alone && !route->neighbour[port].child;
      if (alone) route->unbound = true;
    }
  }
  if (now_us - route->beacon_sent_us >= RS_HEARTBEAT_US) rs_route_beacon(cell, now_us);
}
