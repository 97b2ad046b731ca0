/* SPDX-License-Identifier: Apache-2.0
 * A root wants to give cells to neighbouring trees; cells that touch those offer to move. Each cell passes on the best
 * offer of its subtree: the one that costs fewest hops, then the one that moves most cells. A cell moves with its whole
 * subtree, so that its size is what the root reckons with. */
#include "cell/routing/offers.h"

#include "cell/link/link.h"

enum { MOST_DELTA = 15 }; /* that an offer can tell */

bool rs_demands_open(const rs_route* route) {
  const rs_demands* demands = &route->demands;
  return demands->open != 0U && route->parent_port != RS_NO_PARENT && demands->root == route->wave.root &&
         (uint16_t)(route->wave.sequence - demands->sequence + 1U) <= RS_DEMANDS_TICKS;
}

void rs_offer_better(const rs_route* route, const rs_offer* offer, rs_offer* best) {
  if (offer->cell == RS_ID_NONE || offer->round != route->demands.round) return;
  if (best->cell != RS_ID_NONE) {
    const int32_t cheaper = (int32_t)best->delta - offer->delta;
    const int32_t larger = (int32_t)offer->size - best->size;
    if (cheaper < 0 || (cheaper == 0 && larger < 0)) return;
    if (cheaper == 0 && larger == 0 && offer->cell >= best->cell) return;
  }
  *best = *offer;
}

void rs_offer_own(const rs_cell* cell, rs_offer* best) {
  const rs_route* route = &cell->route;
  /* A root cell stays: without it the port would have no tree. */
  if (cell->id == RS_ID_NONE || route->hops <= 1U || route->handover || route->resting) return;
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    const rs_neighbour* neighbour = &route->neighbour[port];
    if (port + 1U == route->parent_port || !rs_move_open(route, neighbour)) continue;
    const uint32_t hops = neighbour->hops + 1U;
    const uint32_t delta = hops > route->hops ? hops - route->hops : 0U;
    if (delta >= route->wave.gain_threshold) continue;
    for (unsigned w = 0; w < RS_DEMANDS; ++w) {
      if (route->demands.target[w] != neighbour->wave.root) continue;
      if (route->subtree_size > route->demands.size[w]) continue;
      if (hops + route->subtree_height > route->wave.depth_cap) continue;
      const rs_offer own = {.cell = cell->id,
                            .size = route->subtree_size,
                            .delta = (uint8_t)(delta < MOST_DELTA ? delta : MOST_DELTA),
                            .root = neighbour->wave.root,
                            .round = route->demands.round};
      rs_offer_better(route, &own, best);
    }
  }
}
