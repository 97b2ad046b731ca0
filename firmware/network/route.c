/* The parent of a cell. Loop freedom rests on one rule (R2): an advert may be adopted only if it comes strictly before
 * the cell's feasible distance, that is, its sequence is newer, or equal with fewer hops than the cell ever had in it.
 * As a parent's advert never comes before its own feasible distance, and that only moves forward, distances decrease
 * strictly along parents at every instant, whatever is lost, late or switched (DUAL, Garcia-Luna-Aceves 1993; Babel,
 * RFC 8966). Roots issue a new sequence every millisecond, so a cell without a feasible neighbour waits no longer. */
#include "cell/parts.h"

static rs_neighbour* parent_of(rs_route* route) {
  return route->parent_port == RS_NO_PARENT ? 0 : &route->neighbour[(route->parent_port - 1U) % RS_PORTS];
}

uint32_t rs_tick_time(const rs_cell* cell, uint32_t now_us) {
  const uint32_t since_ms = (now_us - cell->route.origin_us) / RS_TICK_US;
  return (rs_wave_time(&cell->route.wave) + since_ms) & ((1U << RS_TICK_TIME_BITS) - 1U);
}

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
  route->advertised_us = now_us;
  cell->queues.advert_due = RS_ALL_PORTS;
  cell->queues.data_most = RS_QUEUE_DATA;
  rs_subtree_update(cell);
}

void rs_route_advertise(rs_cell* cell, uint32_t now_us) {
  cell->queues.advert_due = RS_ALL_PORTS;
  cell->route.advertised_us = now_us;
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
  rs_queues_calm(cell);
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
  if (moved) route->hold = false;
  if (elsewhere) rs_subtree_update(cell);
  rs_route_advertise(cell, now_us);
}

/* The best neighbour to adopt: over a line that does not spoil frames, fewest hops, the own root first, then the lowest
 * port; RS_PORTS if none is feasible. */
static unsigned best_feasible(const rs_route* route, uint32_t now_us) {
  unsigned best = RS_PORTS;
  uint32_t best_cost = 0;
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    const rs_neighbour* neighbour = &route->neighbour[port];
    if (port + 1U == route->parent_port || neighbour->child || !rs_link_usable(neighbour)) continue;
    if (!rs_route_feasible(route, port)) continue;
    const uint32_t cost = (rs_link_spoilt(neighbour, now_us) ? 1024U : 0U) + 2U * neighbour->hops +
                          (neighbour->wave.root != route->wave.root ? 1U : 0U);
    if (best == RS_PORTS || cost < best_cost) {
      best = port;
      best_cost = cost;
    }
  }
  return best;
}

/* Who has a parent has the distance of the wave that it passes on. Where it has not, memory is damaged, and the known
 * time says which of the two: otherwise nobody might be feasible for long. */
static void heal_distance(rs_route* route) {
  if (route->parent_port == RS_NO_PARENT || route->unbound || route->feasible_sequence == route->wave.sequence) return;
  if (route->known_time != ~route->known_time_complement) return;
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
  heal_distance(route); /* without a parent nothing could tell it from a right one */
  const unsigned best = best_feasible(route, now_us);
  if (best < RS_PORTS) {
    rs_route_adopt(cell, best, now_us);
    return;
  }
  route->parent_port = RS_NO_PARENT;
  route->hops = RS_HOPS_POISON;
  route->hold = false;
  route->orphaned_us = now_us;
  ++cell->counts.orphanings;
  rs_identity_changed(cell, now_us);
  rs_subtree_update(cell);
  rs_route_advertise(cell, now_us);
}

/* R4 */
static void tick_of_parent(rs_cell* cell, unsigned port, uint32_t now_us) {
  rs_route* route = &cell->route;
  const rs_neighbour* parent = &route->neighbour[port];
  heal_distance(route);
  if (parent->child || parent->hops >= RS_HOPS_MAX) {
    rs_route_lose(cell, now_us);
  } else if (parent->leaving && rs_move_shed(cell, now_us)) {
    return;
  } else if (rs_newer(parent->wave.sequence, route->wave.sequence)) {
    rs_move_check(cell, now_us);
    rs_move_detour(cell, now_us);
    if (!route->hold) rs_route_adopt(cell, port, now_us);
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
  /* Nobody goes back to a cell at the border while it is to become light, but for being too deep. */
  const bool back = same && neighbour->leaving && !route->neighbour[route->parent_port - 1U].leaving &&
                    route->hops + route->subtree_height <= route->wave.depth_cap;
  const bool spoilt = rs_link_spoilt(neighbour, now_us);
  const bool parent_spoilt = rs_link_spoilt(&route->neighbour[route->parent_port - 1U], now_us);
  if (parent_spoilt && !spoilt && same) {
    rs_route_adopt(cell, port, now_us);
    return;
  }
  if (gain >= 1 && gain >= wanted && !back && (parent_spoilt || !spoilt)) {
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
    route->known_time = rs_wave_time(&route->wave);
    route->known_time_complement = ~route->known_time;
  }
}

void rs_route_check(rs_cell* cell, uint32_t now_us) {
  rs_route* route = &cell->route;
  heal_distance(route);
  /* Without a parent there is no way to advertise, and with one there is. */
  if (route->parent_port == RS_NO_PARENT && route->hops != RS_HOPS_POISON) {
    route->hops = RS_HOPS_POISON;
    rs_route_advertise(cell, now_us);
  }
  if (route->parent_port != RS_NO_PARENT && (route->hops == 0U || route->hops == RS_HOPS_POISON || route->unbound)) {
    rs_route_lose(cell, now_us);
  }
  if (route->in_quarantine) {
    const uint32_t left_us = route->quarantine_us - now_us;
    if (route->parent_port != RS_NO_PARENT || left_us == 0U || left_us > RS_QUARANTINE_US) route->in_quarantine = false;
  }
  rs_links_check(cell, now_us);
  const bool held = route->hold;
  rs_move_check(cell, now_us);

  const rs_neighbour* parent = parent_of(route);
  if (parent != 0) {
    const bool stale = now_us - route->advanced_us >= RS_STALE_LIMIT_US && !rs_link_spoilt(parent, now_us);
    if (!rs_link_usable(parent) || stale) {
      rs_route_lose(cell, now_us);
    } else if (held && !route->hold && rs_newer(parent->wave.sequence, route->wave.sequence)) {
      tick_of_parent(cell, route->parent_port - 1U, now_us); /* what was held back */
    }
  } else if (!route->in_quarantine) {
    const unsigned best = best_feasible(route, now_us);
    if (best < RS_PORTS) {
      rs_route_adopt(cell, best, now_us);
    } else if (now_us - route->orphaned_us >= RS_ORPHAN_RESET_US) {
      /* Nobody hangs on this cell, so it may forget how near it was. */
      bool alone = true;
      for (unsigned port = 0; port < RS_PORTS; ++port) alone = alone && !route->neighbour[port].child;
      if (alone) route->unbound = true;
    }
  }
  if (now_us - route->advertised_us >= RS_HEARTBEAT_US) rs_route_advertise(cell, now_us);
}
