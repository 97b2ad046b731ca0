/* SPDX-License-Identifier: Apache-2.0
 * What was sent to the last parent and may have died with it is sent again to the new one. */
#include "cell/transport/parent_change.h"

#include "cell/link/link.h"
#include "cell/transport/queues.h"

/* A new parent. If the old one was left in good order, only what it has not confirmed is sent again. */
static void move(rs_cell* cell, bool left) {
  rs_arq_sender* arq_sender = &cell->arq_sender;
  arq_sender->event.sent = left ? arq_sender->event.confirmed : 0U;
  arq_sender->event.confirmed = arq_sender->event.sent;
  arq_sender->torque.sent = arq_sender->torque.confirmed = arq_sender->torque.tried;
  arq_sender->announcements = 0;
}

/* Since when an old parent has heard nothing of this cell. Of one that has rebooted or is stuck, the last frame tells
 * less than the last new tick; one that is still heard to say that it does not hear this cell has waited for it. */
static uint32_t silent_since_us(const rs_neighbour* old, uint32_t now_us) {
  const uint32_t silent_us = now_us - old->turned_us;
  const uint32_t waited_us = RS_LINK_DOWN_US + RS_TICK_US;
  return now_us - (old->up && silent_us < waited_us ? waited_us : silent_us);
}

void rs_arq_sender_move(rs_cell* cell, uint32_t now_us) {
  rs_arq_sender* arq_sender = &cell->arq_sender;
  const rs_route* route = &cell->route;
  const unsigned old_port = arq_sender->parent_port;
  arq_sender->parent_port = route->parent_port;
  arq_sender->parent_changes = cell->counts.parent_changes;
  if (old_port != RS_NO_PARENT) {
    const rs_neighbour* old = &route->neighbour[(old_port - 1U) % RS_PORTS];
    const uint16_t behind = (uint16_t)(route->wave.sequence - old->wave.sequence);
    const bool silent = !rs_link_usable(old) || (behind > 2U && behind < 0x8000U);
    arq_sender->was_silent = silent || rs_link_lossy(old, now_us);
    arq_sender->silent_us = silent ? silent_since_us(old, now_us) : now_us - RS_LOSSY_SILENT_US;
    arq_sender->was_lost = silent || old->hops == RS_HOPS_POISON || route->parent_port == RS_NO_PARENT;
  }
  if (route->parent_port == RS_NO_PARENT) return;
  if (arq_sender->was_silent) rs_queues_repeat_lost(cell, arq_sender->silent_us, now_us);
  cell->queues.data_sent = 0; /* to this parent */
  move(cell, !arq_sender->was_lost);
}
