/* Which frame an idle port sends next: adverts first, because recovery waits for them; then, towards the parent,
 * torque sums, status, events, samples and reports; towards children, commands and joint states. Nothing is
 * interrupted, and nothing waits for ever: samples and reports have a share of their own. */
#include <string.h>

#include "network/rings.h"

enum {
  SLOW_SHARE = 8,       /* one slow frame is sent for every so many others, if any waits, */
  SLOW_SHARE_FULL = 32, /* or so many while samples are half a queue behind: slow ones come again, samples do not, */
  DATA_SHARE = 2        /* and one clock sample */
};

uint32_t rs_advert_wait_us(const rs_cell* cell, unsigned port, uint32_t now_us) {
  const rs_queues* queues = &cell->queues;
  const uint32_t since_us = now_us - queues->advert_us[port][queues->advert_next[port] % RS_ADVERTS];
  return since_us < RS_ADVERTS_US ? RS_ADVERTS_US - since_us : 0U;
}

static void note_advert(rs_queues* queues, unsigned port, uint32_t now_us) {
  const unsigned at = queues->advert_next[port] % RS_ADVERTS;
  queues->advert_us[port][at] = now_us;
  queues->advert_next[port] = (uint8_t)((at + 1U) % RS_ADVERTS);
}

/* A bucket that holds a burst of status frames and fills again by one in each mean time; `status_spent_us` is when it
 * is full. A time further off than an empty bucket needs is damaged memory. */
static uint32_t status_spent_us(const rs_cell* cell, uint32_t now_us) {
  const uint32_t spent_us = cell->route.status_spent_us - now_us;
  return spent_us <= RS_STATUS_BURST * RS_STATUS_MEAN_US ? spent_us : 0U;
}

uint32_t rs_status_wait_us(const rs_cell* cell, uint32_t now_us) {
  const uint32_t since_us = now_us - cell->route.reported_us;
  const uint32_t pause_us = since_us < RS_STATUS_PAUSE_US ? RS_STATUS_PAUSE_US - since_us : 0U;
  /* Offers use the upper half of the bucket, so that levelling leaves sizes a burst. */
  const uint32_t burst = cell->queues.size_due ? RS_STATUS_BURST : RS_STATUS_BURST / 2U;
  const uint32_t spent_us = status_spent_us(cell, now_us), enough_us = (burst - 1U) * RS_STATUS_MEAN_US;
  const uint32_t fill_us = spent_us > enough_us ? spent_us - enough_us : 0U;
  return pause_us > fill_us ? pause_us : fill_us;
}

static void note_status(rs_cell* cell, uint32_t now_us) {
  cell->route.status_spent_us = now_us + status_spent_us(cell, now_us) + RS_STATUS_MEAN_US;
  cell->route.reported_us = now_us;
}

static RS_APART void pack_advert(rs_cell* cell, unsigned port, uint32_t now_us, uint8_t* frame) {
  const rs_route* route = &cell->route;
  const rs_neighbour* neighbour = &route->neighbour[port];
  uint32_t age_us = now_us - route->origin_us;
  if (age_us > 0xFFFU) age_us = 0xFFFU;
  /* A link that is kept out is so for both. */
  const bool heard = neighbour->good > 0U && !neighbour->held && now_us - neighbour->heard_us < RS_LINK_DOWN_US;
  rs_tick tick = {
      .type = RS_TYPE_tick,
      .hops = route->hops,
      .sender = cell->id,
      .sender_port = port,
      .nonce = cell->nonce,
      .parent = route->parent_port == port + 1U,
      .heard = heard,
      .echo = route->parent_port == port + 1U ? rs_retention_announce(cell) : rs_hearing_echo(&neighbour->hearing),
      .leaving = (route->hold && !route->hold_whole) || route->yielding != 0U,
      .age_us = age_us};
  rs_wave_into_tick(&tick, &route->wave);
  rs_tick_pack(frame, &tick);
  rs_frame_seal(frame);
}

static bool next_for_parent(rs_cell* cell, uint32_t now_us, uint8_t* frame) {
  rs_queues* queues = &cell->queues;
  const unsigned slow_share = queues->data.count > RS_QUEUE_DATA / 2U ? SLOW_SHARE_FULL : SLOW_SHARE;
  if (queues->slow.count > 0U && queues->passed_over >= slow_share) {
    queues->passed_over = 0;
    return rs_ring_take(&queues->slow, queues->slow_frame, RS_QUEUE_SLOW, frame);
  }
  if (queues->slow.count > 0U) ++queues->passed_over;
  if (rs_retention_next_torque(cell, frame, now_us)) return true;
  /* Not before the advert by which a new parent learns that this is its child: it would not listen. */
  const bool told = (queues->advert_due >> (cell->route.parent_port - 1U) & 1U) == 0U;
  if (queues->status_due && told && rs_status_wait_us(cell, now_us) == 0U) {
    note_status(cell, now_us);
    rs_subtree_pack(cell, frame);
    return true;
  }
  if (queues->data.count > 0U && queues->data_passed_over < DATA_SHARE) {
    if (rs_retention_next_event(cell, frame, now_us)) return ++queues->data_passed_over, true;
  }
  queues->data_passed_over = 0;
  if (queues->data.count > 0U) {
    const bool again = queues->data_again > 0U;
    rs_samples_take(queues, now_us, frame);
    if (again) {
      --queues->data_again;
      rs_frame_mark_replayed(frame);
    }
    return true;
  }
  if (rs_retention_next_event(cell, frame, now_us)) return true;
  queues->passed_over = 0;
  return rs_ring_take(&queues->slow, queues->slow_frame, RS_QUEUE_SLOW, frame);
}

static RS_APART bool next_for_child(rs_cell* cell, unsigned port, uint8_t* frame) {
  rs_queues* queues = &cell->queues;
  const uint8_t bit = (uint8_t)(1U << port);
  for (unsigned i = 0; i < queues->down.count; ++i) {
    const unsigned at = (queues->down.first + i) & (RS_QUEUE_DOWN - 1U);
    if ((queues->down_ports[at] & bit) == 0U) continue;
    memcpy(frame, queues->down_frame[at], RS_FRAME_BYTES);
    queues->down_ports[at] &= (uint8_t)~bit;
    while (queues->down.count > 0U && queues->down_ports[queues->down.first & (RS_QUEUE_DOWN - 1U)] == 0U) {
      queues->down.first = (uint8_t)((queues->down.first + 1U) & (RS_QUEUE_DOWN - 1U));
      --queues->down.count;
    }
    return true;
  }
  return false;
}

RS_APART unsigned rs_transmit_start(rs_cell* cell, unsigned ready, uint32_t now_us) {
  rs_queues* queues = &cell->queues;
  unsigned started = 0;
  rs_cell_hold_indices(cell);
  for (unsigned port = 0; ready != 0U; ++port, ready >>= 1) {
    if ((ready & 1U) == 0U) continue;
    const uint8_t bit = (uint8_t)(1U << port);
    uint8_t* frame = queues->sending[port];
    bool found;
    /* A torque sum before the advert that announces it, so that its loss shows at once. */
    const bool torque_first = port + 1U == cell->route.parent_port && cell->retention.announcements > 0U;
    if (torque_first && rs_retention_next_torque(cell, frame, now_us)) {
      found = true;
    } else if ((queues->advert_due & bit) != 0U && rs_advert_wait_us(cell, port, now_us) == 0U) {
      queues->advert_due &= (uint8_t)~bit;
      note_advert(queues, port, now_us);
      pack_advert(cell, port, now_us, frame);
      found = true;
    } else if (port + 1U == cell->route.parent_port) {
      found = next_for_parent(cell, now_us, frame);
    } else {
      found = queues->down.count > 0U && next_for_child(cell, port, frame);
    }
    if (!found) continue;
    queues->busy |= bit;
    queues->started_us[port] = now_us;
    started |= bit;
  }
  return started;
}

void rs_transmit(rs_cell* cell, uint32_t now_us, rs_output* output) {
  unsigned waiting = rs_transmit_wanted(cell);
  const unsigned ready = waiting & ~(unsigned)cell->queues.busy;
  if (ready != 0U) {
    rs_output_start(output, &cell->queues, rs_transmit_start(cell, ready, now_us));
    waiting = rs_transmit_wanted(cell);
  }
  output->waiting = cell->queues.waiting = (uint8_t)waiting;
}
