/* SPDX-License-Identifier: Apache-2.0
 * Links that come up and fall (R1), and what follows from that for route, reports and the subtree. */
#include "cell/routing/links.h"

#include "cell/link/link.h"
#include "cell/routing/identity.h"
#include "cell/routing/parent.h"
#include "cell/routing/subtree.h"

/* Doubles with each loss. */
static uint32_t hold_down_us(uint32_t flaps) {
  uint32_t hold_us = RS_HOLD_DOWN_US;
  for (; flaps > 1U && hold_us < RS_HOLD_DOWN_MAX_US; --flaps) hold_us *= 2U;
  return hold_us < RS_HOLD_DOWN_MAX_US ? hold_us : RS_HOLD_DOWN_MAX_US;
}

static void set_flaps(rs_neighbour* neighbour, uint32_t flaps) {
  neighbour->flaps = (uint8_t)flaps;
  neighbour->flaps_complement = (uint8_t)~flaps;
}

static void check_flaps(rs_neighbour* neighbour) {
  if ((neighbour->flaps ^ neighbour->flaps_complement) == 0xFF) return;
  set_flaps(neighbour, 0);
  neighbour->hold_down = false;
}

void rs_link_down(rs_cell* cell, unsigned port, uint32_t now_us) {
  rs_neighbour* neighbour = &cell->route.neighbour[port];
  const bool parent = cell->route.parent_port == port + 1U;
  check_flaps(neighbour);
  if (neighbour->up) {
    /* A link that falls again soon after coming up is kept out for longer and longer. */
    if (now_us - neighbour->up_us >= RS_FLAP_FORGET_US) set_flaps(neighbour, 0);
    if (neighbour->flaps > 0U) {
      neighbour->hold_down = true;
      neighbour->hold_down_until_us = now_us + hold_down_us(neighbour->flaps);
    }
    if (neighbour->flaps < 16U) set_flaps(neighbour, neighbour->flaps + 1U);
  }
  neighbour->up = false;
  neighbour->good = 0;
  neighbour->hops = RS_HOPS_POISON;
  if (neighbour->child) neighbour->arq_receiver.kept = true;
  neighbour->child = false;
  neighbour->hears_us = false;
  rs_identity_changed(cell, now_us);
  if (parent) {
    rs_route_lose(cell, now_us);
  } else {
    rs_subtree_update(cell);
  }
}

void rs_link_heard(rs_cell* cell, unsigned port, uint32_t now_us) {
  rs_neighbour* neighbour = &cell->route.neighbour[port];
  if (now_us - neighbour->heard_us >= RS_LINK_DOWN_US) {
    if (neighbour->up) rs_link_down(cell, port, now_us);
    neighbour->good = 0;
  }
  neighbour->heard_us = now_us;
  if (neighbour->up) return;
  if (neighbour->good < RS_LINK_UP_FRAMES) ++neighbour->good;
  if (neighbour->good < RS_LINK_UP_FRAMES || !neighbour->met) return;
  check_flaps(neighbour);
  if (neighbour->hold_down) {
    const uint32_t left_us = neighbour->hold_down_until_us - now_us;
    /* Where there is no other way, one that falls now and then is better than none. */
    const bool cut_off =
        cell->route.parent_port == RS_NO_PARENT && now_us - cell->route.orphaned_us >= RS_HOLD_DOWN_ALONE_US;
    if (!cut_off && left_us != 0U && neighbour->flaps > 1U && neighbour->flaps <= 16U &&
        left_us <= hold_down_us(neighbour->flaps - 1U))
      return;
    neighbour->hold_down = false;
  }
  neighbour->up = true;
  neighbour->up_us = now_us;
  rs_identity_changed(cell, now_us);
}

void rs_links_check(rs_cell* cell, uint32_t now_us) {
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    rs_neighbour* neighbour = &cell->route.neighbour[port];
    if (neighbour->up && now_us - neighbour->heard_us >= RS_LINK_DOWN_US) rs_link_down(cell, port, now_us);
    if (neighbour->up) neighbour->hold_down = false; /* damaged memory: a link that is kept out is down */
    /* A stuck cell may say the same for ever; a cell that has forgotten how near it was must not believe it again. */
    if (now_us - neighbour->turned_us >= RS_STALE_LIMIT_US) neighbour->stale = true;
    const bool lagging = rs_link_lagging(&cell->route, neighbour, now_us);
    if (lagging != (neighbour->lagging != 0U)) {
      neighbour->lagging = lagging;
      rs_subtree_update(cell);
    }
    /* Nothing is there; should memory say otherwise, it is damaged. */
    if (now_us - neighbour->heard_us >= RS_LINK_DOWN_US) {
      neighbour->child = neighbour->hears_us = false;
      neighbour->hops = RS_HOPS_POISON;
      neighbour->heard_us = now_us - RS_LINK_DOWN_US; /* does not come round again */
    }
  }
}
