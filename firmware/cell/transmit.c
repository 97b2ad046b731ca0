/* SPDX-License-Identifier: Apache-2.0
 * Which frame an idle port sends next: beacons first, because recovery waits for them; then, towards the parent,
 * torque sums, status, events, samples and reports; towards children, commands and joint states. Nothing is
 * interrupted, and nothing waits for ever: samples and reports have a share of their own. */
#include "cell/transmit.h"

#include <string.h>

#include "cell/link/link.h"
#include "cell/memory/integrity.h"
#include "cell/routing/subtree.h"
#include "cell/time/timer.h"
#include "cell/transport/arq_sender.h"
#include "cell/transport/rings.h"
#include "cell/wire/frame_copy.h"
#include "robotskin/crc.h"

enum {
  SLOW_SHARE_FULL = 32, /* RS_SLOW_SHARE while samples are half a queue behind: slow ones come again, samples do not */
  DATA_SHARE = 2        /* and one clock sample */
};

/* A beacon but for the fields of the link that it is for, which have 0. */
static RS_NOINLINE void pack_beacon(const rs_cell* cell, uint32_t now_us, uint8_t* frame) {
  const rs_route* route = &cell->route;
  rs_tick tick = {.type = RS_TYPE_tick,
                  .hops = route->hops,
                  .sender = cell->id,
                  .nonce = cell->nonce,
                  .draining = route->draining_ticks != 0U || rs_route_lossy(route, now_us),
                  .age_4us = rs_tick_age(now_us - route->origin_us + cell->step_us)};
  rs_wave_into_tick(&tick, &route->wave);
  rs_tick_pack(frame, &tick);
  rs_frame_seal(frame);
}

/* Such a beacon for one port. */
static RS_NOINLINE RS_HOT void address_beacon(rs_cell* cell, unsigned port, const uint8_t* base, uint32_t now_us) {
  const rs_neighbour* neighbour = &cell->route.neighbour[port];
  uint32_t words[5] = {0};
  rs_bits_put(words, RS_tick_sender_port_AT, 2, port);
  unsigned link = port << 2;
  /* A link that is kept out is so for both. */
  if (neighbour->good > 0U && !neighbour->hold_down && now_us - neighbour->heard_us < RS_LINK_DOWN_US) {
    rs_bits_put(words, RS_tick_heard_AT, 1, 1);
    link |= 1U;
  }
  uint32_t ack;
  if (cell->route.parent_port == port + 1U) {
    rs_bits_put(words, RS_tick_parent_AT, 1, 1);
    link |= 2U;
    ack = rs_arq_sender_announce(cell) & 0xFFU;
  } else {
    ack = rs_arq_receiver_ack(&neighbour->arq_receiver);
  }
  rs_bits_put(words, RS_tick_ack_AT, 8, ack);
  uint8_t* frame = rs_sending_next(&cell->queues, port);
  rs_frame_copy(frame, base);
  rs_frame_set_word(frame, 1, rs_frame_word(frame, 1) | words[1]);
  rs_frame_set_word(frame, 2, rs_frame_word(frame, 2) | words[2]);
  rs_frame_change_checksum(frame, (uint32_t)rs_tick_link_change[link] ^ rs_tick_ack_change[ack]);
}

/* Starts a beacon on each of these ports that may have one already; on which it did. */
static RS_NOINLINE RS_HOT unsigned start_beacons(rs_cell* cell, unsigned due, uint32_t now_us) {
  rs_queues* queues = &cell->queues;
  RS_WORDS uint8_t base[RS_FRAME_BYTES];
  unsigned started = 0;
  for (unsigned port = 0; due != 0U; ++port, due >>= 1) {
    if ((due & 1U) == 0U) continue;
    const unsigned next = queues->beacon_next[port] % RS_BEACONS;
    uint32_t* last_us = &queues->beacon_us[port][next];
    if (now_us - *last_us < RS_BEACONS_US) continue;
    *last_us = now_us;
    queues->beacon_next[port] = (uint8_t)((next + 1U) % RS_BEACONS);
    if (started == 0U) pack_beacon(cell, now_us, base);
    started |= 1U << port;
    address_beacon(cell, port, base, now_us);
  }
  queues->beacon_due &= (uint8_t)~started;
  return started;
}
RS_STATIC_ASSERT((int)RS_tick_sender_port_AT >= 32 && (int)RS_tick_heard_LAST < 64 && (int)RS_tick_ack_AT >= 64 &&
                     (int)RS_tick_ack_LAST < 96,
                 "the fields of a link stand in words 1 and 2");

static bool next_for_parent(rs_cell* cell, uint32_t now_us, uint8_t* frame) {
  rs_queues* queues = &cell->queues;
  const unsigned slow_share = queues->data.count > RS_QUEUE_DATA / 2U ? SLOW_SHARE_FULL : RS_SLOW_SHARE;
  if (queues->slow.count > 0U && queues->passed_over >= slow_share) {
    queues->passed_over = 0;
    return rs_ring_take(&queues->slow, queues->slow_frame, RS_QUEUE_SLOW, frame);
  }
  if (queues->slow.count > 0U) ++queues->passed_over;
  if (rs_arq_sender_next_torque(cell, frame, now_us)) return true;
  /* Not before the beacon by which a new parent learns that this is its child: it would not listen. */
  const bool told = (queues->beacon_due >> (cell->route.parent_port - 1U) & 1U) == 0U;
  if (queues->status_due && told && rs_status_wait_us(cell, now_us) == 0U) {
    rs_status_note(cell, now_us);
    rs_subtree_pack(cell, frame);
    return true;
  }
  if (queues->data.count > 0U && queues->data_passed_over < DATA_SHARE) {
    if (rs_arq_sender_next_event(cell, frame, now_us)) return ++queues->data_passed_over, true;
  }
  queues->data_passed_over = 0;
  if (queues->data.count > 0U) {
    const bool again = queues->data_again > 0U;
    rs_samples_take(queues, now_us, frame);
    if (again) {
      --queues->data_again;
      rs_frame_mark_retransmitted(frame);
    }
    return true;
  }
  if (rs_arq_sender_next_event(cell, frame, now_us)) return true;
  queues->passed_over = 0;
  return rs_ring_take(&queues->slow, queues->slow_frame, RS_QUEUE_SLOW, frame);
}

static RS_NOINLINE bool next_for_child(rs_cell* cell, unsigned port, uint8_t* frame) {
  rs_queues* queues = &cell->queues;
  const uint8_t bit = (uint8_t)(1U << port);
  for (unsigned i = 0; i < queues->down.count; ++i) {
    const unsigned at = (queues->down.first + i) & (RS_QUEUE_DOWN - 1U);
    if ((queues->down_ports[at] & bit) == 0U) continue;
    rs_frame_copy(frame, queues->down_frame[at]);
    queues->down_ports[at] &= (uint8_t)~bit;
    rs_down_let_go(queues);
    return true;
  }
  return false;
}

/* Whether nothing but events waits, and that for the parent. */
static bool events_alone(const rs_cell* cell, unsigned ready) {
  const rs_queues* queues = &cell->queues;
  return ready == queues->parent_bit && queues->parent_port == cell->route.parent_port &&
         (queues->beacon_due & ready) == 0U &&
         (queues->status_due | queues->slow.count | queues->data.count | queues->down.count) == 0U &&
         cell->arq_sender.torque.sent >= cell->arq_sender.torque.count;
}

/* What the long way below does then. */
static RS_NOINLINE unsigned start_event(rs_cell* cell, unsigned ready, uint32_t now_us) {
  rs_queues* queues = &cell->queues;
  const unsigned port = (queues->parent_port - 1U) % RS_PORTS;
  queues->data_passed_over = 0;
  if (!rs_arq_sender_next_event(cell, rs_sending_next(queues, port), now_us)) {
    queues->passed_over = 0;
    return 0;
  }
  queues->busy |= (uint8_t)ready;
  queues->started_us[port] = now_us;
  rs_sending_turn(queues, port);
  return ready;
}

RS_NOINLINE unsigned rs_transmit_start(rs_cell* cell, unsigned ready, uint32_t now_us) {
  rs_queues* queues = &cell->queues;
  rs_cell_hold_indices(cell);
  if (events_alone(cell, ready)) return start_event(cell, ready, now_us);
  const unsigned parent_port = (cell->route.parent_port - 1U) % RS_PORTS;
  const unsigned parent = 1U << cell->route.parent_port >> 1;
  unsigned started = 0;
  /* A torque sum before the beacon that announces it, so that its loss shows at once. */
  if ((ready & parent) != 0U && cell->arq_sender.announcements > 0U &&
      rs_arq_sender_next_torque(cell, rs_sending_next(queues, parent_port), now_us)) {
    started = parent;
  }
  const unsigned beacons = ready & ~started & queues->beacon_due;
  if (beacons != 0U) started |= start_beacons(cell, beacons, now_us);
  ready &= ~started;
  if ((ready & parent) != 0U && next_for_parent(cell, now_us, rs_sending_next(queues, parent_port))) started |= parent;
  if (queues->down.count > 0U) {
    for (unsigned port = 0, others = ready & ~parent; others != 0U; ++port, others >>= 1) {
      if ((others & 1U) != 0U && next_for_child(cell, port, rs_sending_next(queues, port))) started |= 1U << port;
    }
  }
  queues->busy |= (uint8_t)started;
  for (unsigned port = 0, rest = started; rest != 0U; ++port, rest >>= 1) {
    if ((rest & 1U) == 0U) continue;
    queues->started_us[port] = now_us;
    rs_sending_turn(queues, port);
  }
  return started;
}

RS_HOT void rs_transmit(rs_cell* cell, uint32_t now_us, rs_output* output) {
  unsigned waiting = rs_transmit_wanted(cell);
  const unsigned ready = waiting & ~(unsigned)cell->queues.busy;
  if (ready != 0U) {
    rs_output_start(output, &cell->queues, rs_transmit_start(cell, ready, now_us));
    waiting = rs_transmit_wanted(cell);
  }
  output->waiting = cell->queues.waiting = (uint8_t)waiting;
}
