/* SPDX-License-Identifier: Apache-2.0
 * What a neighbour's tick says of it, taken only if a root made its wave and it is no older than what the neighbour has
 * said already; then the route may turn. */
#include "cell/routing/beacons.h"

#include "cell/link/link.h"
#include "cell/memory/known_time.h"
#include "cell/routing/identity.h"
#include "cell/routing/links.h"
#include "cell/routing/refusal.h"
#include "cell/routing/route.h"
#include "cell/routing/subtree.h"
#include "cell/transport/arq_sender.h"
#include "cell/wire/tags.h"
#include "cell/wire/wave.h"

/* Whether a wave is from before the known time by more than the sequence numbers in flight: a tick played again. */
static bool is_past(const rs_cell* cell, const rs_wave* wave) {
  const uint32_t ahead = rs_time_ahead(&cell->route, wave);
  return rs_time_known(&cell->route) && ahead >= RS_TICK_TIME_HALF && !rs_time_went_back(ahead);
}

/* Whether a root made this wave: what the own parent said before needs no proof, where its time is known. */
static bool authentic(const rs_cell* cell, const rs_wave* wave) {
  if (rs_time_known(&cell->route) && rs_waves_equal(wave, &cell->route.wave)) return true;
  return rs_tags_equal(rs_wave_tag(&cell->key, wave), wave->tag);
}

/* Whether a tick is from before what this neighbour has said, and so replayed: time never goes back. One that has lost
 * its way comes back with a newer wave alone, as an equal one may be what it said before it was lost. Only a cell
 * long without a way may forget; so an old wave counts once the neighbour's own has stood still, and it has not
 * said for three heartbeats that there is no way: a cell that seems to say both is two cells. One that has just booted
 * names no root. If the memory of what it said is damaged, that is of no account as soon as it stands still. */
static bool from_before(const rs_neighbour* neighbour, const rs_tick* tick, const rs_wave* wave, uint32_t now_us) {
  if (!neighbour->met) return false;
  const bool lost = neighbour->hops == RS_HOPS_POISON;
  if (tick->hops == RS_HOPS_POISON && (lost || neighbour->stale)) return false;
  if (neighbour->stale && now_us - neighbour->poisoned_us >= RS_LINK_DOWN_US) return false;
  if (tick->root == 0U) return neighbour->nonce == tick->nonce && neighbour->wave.root != 0U;
  const uint32_t behind = rs_ticks_between(rs_wave_time(wave), rs_wave_time(&neighbour->wave));
  return behind < RS_TICK_TIME_HALF && (behind > 0U || lost);
}

void rs_beacon_tick(rs_cell* cell, unsigned port, const uint8_t* frame, uint32_t came_us, uint32_t now_us) {
  rs_route* route = &cell->route;
  rs_neighbour* neighbour = &route->neighbour[port];
  rs_tick tick;
  rs_tick_unpack(&tick, frame);
  rs_wave wave;
  rs_wave_of_tick(&wave, &tick);

  /* What is refused changes nothing. A way that is lost needs no proof: it only takes one away. */
  const bool poison = tick.hops == RS_HOPS_POISON;
  const bool known = rs_waves_equal(&wave, &neighbour->wave);
  if (from_before(neighbour, &tick, &wave, now_us) ||
      (!poison && (wave.root == 0U || (cell->keyed && !known && is_past(cell, &wave))))) {
    ++cell->counts.tags_refused;
    return;
  }
  if (!poison && cell->keyed && !known && !authentic(cell, &wave)) {
    rs_refuse_tag(cell, port, now_us);
    return;
  }
  if (neighbour->met && neighbour->nonce != tick.nonce) {
    /* It rebooted: all that was learnt from it is void. */
    if (neighbour->up) rs_link_down(cell, port, now_us);
    neighbour->arq_receiver.kept = false;
    neighbour->good = 1;
  }
  neighbour->met = true;
  neighbour->nonce = (uint8_t)tick.nonce;
  if (neighbour->id != tick.sender || neighbour->port != tick.sender_port + 1U) {
    neighbour->id = (uint16_t)tick.sender;
    neighbour->port = (uint8_t)(tick.sender_port + 1U);
    rs_identity_changed(cell, now_us);
  }
  const bool was_child = neighbour->child, was_draining = neighbour->draining;
  const uint8_t old_hops = neighbour->hops, old_root = neighbour->wave.root;
  neighbour->hears_us = tick.heard != 0U;
  neighbour->child = tick.parent != 0U;
  neighbour->draining = tick.draining != 0U;
  if (neighbour->child != was_child) {
    if (!was_child) rs_subtree_forget(neighbour);
    rs_subtree_update(cell);
  }
  rs_arq_sender_tick(cell, port, &tick, was_child, came_us, now_us);

  if (poison) {
    neighbour->hops = RS_HOPS_POISON;
    neighbour->poisoned_us = now_us;
  } else {
    /* R8: nothing legitimate runs far ahead of a parent that is alive. */
    const uint16_t ahead = (uint16_t)(wave.sequence - route->wave.sequence);
    if (route->parent_port != RS_NO_PARENT && now_us - route->advanced_us < RS_STALE_TICKS * RS_TICK_US &&
        ahead > RS_SEQUENCE_WINDOW && ahead < 0x8000U) {
      return;
    }
    if (!rs_waves_equal(&wave, &neighbour->wave)) {
      neighbour->turned_us = now_us;
      neighbour->stale = false;
    }
    neighbour->wave = wave;
    neighbour->hops = (uint8_t)tick.hops;
    neighbour->origin_us = came_us - RS_FRAME_US - RS_AGE_STEP_US * tick.age_4us;
  }
  const bool was_lagging = neighbour->lagging;
  if (was_lagging) neighbour->lagging = rs_link_lagging(route, neighbour, now_us);
  if (port + 1U != route->parent_port && (was_lagging || neighbour->hops != old_hops ||
                                          neighbour->wave.root != old_root || neighbour->draining != was_draining)) {
    rs_subtree_update(cell);
  }
  rs_route_turn(cell, port, now_us);
}
