/* SPDX-License-Identifier: Apache-2.0
 * The parent of a cell: which neighbour may be it (R2), becoming its child (R3), losing it (R5).
 *
 * Loop freedom rests on one rule (R2): a beacon may be adopted only if it comes strictly before the cell's feasible
 * distance, that is, its sequence is newer, or equal with fewer hops than the cell ever had in it. As a parent's beacon
 * never comes before its own feasible distance, and that only moves forward, distances decrease strictly along parents
 * at every instant, whatever is lost, late or switched (DUAL, Garcia-Luna-Aceves 1993; Babel, RFC 8966). Roots issue a
 * new sequence every millisecond, so a cell without a feasible neighbour waits no longer. */
#include "cell/routing/parent.h"

#include "cell/link/link.h"
#include "cell/memory/known_time.h"
#include "cell/routing/identity.h"
#include "cell/routing/subtree.h"
#include "cell/time/sample_clock.h"
#include "cell/time/timer.h"
#include "cell/transport/queues.h"
#include "cell/wire/ports.h"
#include "robotskin/feasibility.h"

void rs_route_boot(rs_cell* cell, uint32_t now_us) {
  rs_route* route = &cell->route;
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    route->neighbour[port].hops = RS_HOPS_POISON;
    route->neighbour[port].heard_us = now_us - RS_LINK_DOWN_US;
  }
  route->hops = RS_HOPS_POISON;
  route->feasible_hops = RS_HOPS_POISON;
  route->unbound = true;
  route->in_quarantine = true;
  route->quarantine_us = now_us + RS_QUARANTINE_US;
  route->orphaned_us = route->advanced_us = route->origin_us = now_us;
  route->reported_us = now_us - RS_STATUS_US;
  route->beacon_sent_us = now_us;
  cell->queues.beacon_due = RS_ALL_PORTS;
  cell->queues.data_most = RS_QUEUE_DATA;
  rs_subtree_update(cell);
}

void rs_route_beacon(rs_cell* cell, uint32_t now_us) {
  cell->queues.beacon_due = RS_ALL_PORTS;
  cell->route.beacon_sent_us = now_us;
  rs_timer_set(cell, now_us);
}

/* R2 */
bool rs_route_feasible(const rs_route* route, unsigned port) {
  const rs_neighbour* neighbour = &route->neighbour[port];
  if (neighbour->stale) return false;
  const rs_distance bound = {route->feasible_sequence, route->feasible_hops};
  const rs_distance offer = {neighbour->wave.sequence, neighbour->hops};
  return rs_feasible(route->unbound, bound, offer);
}

/* R3 */
void rs_route_adopt(rs_cell* cell, unsigned port, uint32_t now_us) {
  rs_route* route = &cell->route;
  const rs_neighbour* neighbour = &route->neighbour[port];
  const bool moved = route->parent_port != port + 1U;
  const bool elsewhere = moved || route->wave.root != neighbour->wave.root || route->hops != neighbour->hops + 1U;
  if (moved) {
    if (route->parent_port == RS_NO_PARENT && now_us - route->orphaned_us > RS_ORPHAN_KEEP_US) {
      rs_queues_forget_samples(cell);
    }
    ++cell->counts.parent_changes;
    rs_identity_changed(cell, now_us);
    cell->queues.status_due = cell->queues.size_due = true;
  }
  if (moved || route->wave.root != neighbour->wave.root) rs_sampling_refresh(cell, now_us);

  route->parent_port = (uint8_t)(port + 1U);
  if (moved) rs_queues_turn(cell);
  route->hops = (uint8_t)(neighbour->hops + 1U);
  route->wave = neighbour->wave;
  route->origin_us = neighbour->origin_us;
  rs_queues_relax(cell);
  if (route->unbound || rs_newer(route->wave.sequence, route->feasible_sequence)) {
    route->unbound = false;
    route->feasible_sequence = route->wave.sequence;
    route->feasible_hops = route->hops;
    route->advanced_us = now_us;
  } else if (route->hops < route->feasible_hops) {
    route->feasible_hops = route->hops;
  }
  if (!route->timed) {
    route->timed = true;
    rs_sampling_restart(cell, now_us);
  }
  if (moved) route->handover = false;
  if (elsewhere) rs_subtree_update(cell);
  rs_route_beacon(cell, now_us);
}

enum { LOSSY_COST = 1024 }; /* more than any number of hops */

/* Whether the wave that is kept of a neighbour is ahead of the known time by more than a path may be behind before it
 * is lost: memory is damaged, or all time has leapt, which its next tick tells. */
bool rs_route_runs_ahead(const rs_route* route, const rs_neighbour* neighbour) {
  enum { AHEAD_MOST = RS_STALE_LIMIT_US / RS_TICK_US + RS_SEQUENCE_WINDOW };
  const uint32_t ahead = rs_time_ahead(route, &neighbour->wave);
  return rs_time_known(route) && ahead > AHEAD_MOST && ahead < RS_TICK_TIME_HALF;
}

/* The best neighbour to adopt: over a line that does not spoil frames, fewest hops, the own root first, then the lowest
 * port; RS_PORTS if none is feasible. */
unsigned rs_route_best_feasible(const rs_route* route, uint32_t now_us) {
  unsigned best = RS_PORTS;
  uint32_t best_cost = 0;
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    const rs_neighbour* neighbour = &route->neighbour[port];
    if (port + 1U == route->parent_port || neighbour->child || !rs_link_usable(neighbour)) continue;
    if (!rs_route_feasible(route, port) || rs_route_runs_ahead(route, neighbour)) continue;
    const uint32_t cost = (rs_link_lossy(neighbour, now_us) ? LOSSY_COST : 0U) + 2U * neighbour->hops +
                          (neighbour->wave.root != route->wave.root ? 1U : 0U);
    if (best == RS_PORTS || cost < best_cost) {
      best = port;
      best_cost = cost;
    }
  }
  return best;
}

/* A cell with a parent has the distance of the wave that it passes on. Else memory is damaged, and the known time
 * says which of the two: otherwise no cell might be feasible for long. */
void rs_route_heal_distance(rs_route* route) {
  if (route->parent_port == RS_NO_PARENT || route->unbound || route->feasible_sequence == route->wave.sequence) return;
  if (!rs_time_known(route)) return;
  if ((uint16_t)route->known_time == route->wave.sequence) {
    route->feasible_sequence = route->wave.sequence;
    if (route->hops < route->feasible_hops) route->feasible_hops = route->hops;
  } else if ((uint16_t)route->known_time == route->feasible_sequence) {
    route->wave.sequence = route->feasible_sequence;
  }
}

/* R5 */
void rs_route_lose(rs_cell* cell, uint32_t now_us) {
  rs_route* route = &cell->route;
  rs_route_heal_distance(route); /* without a parent nothing could tell it from a right one */
  const unsigned best = rs_route_best_feasible(route, now_us);
  if (best < RS_PORTS) {
    rs_route_adopt(cell, best, now_us);
    return;
  }
  route->parent_port = RS_NO_PARENT;
  route->hops = RS_HOPS_POISON;
  route->handover = false;
  route->orphaned_us = now_us;
  ++cell->counts.orphanings;
  rs_identity_changed(cell, now_us);
  rs_subtree_update(cell);
  rs_route_beacon(cell, now_us);
}
