/* SPDX-License-Identifier: Apache-2.0
 * The short way of what a cell gets most often: samples, events and reports of its subtree, frames that are out, and
 * ticks of neighbours that say only that they are still there.
 *
 * The cell at a section unit passes on a sample of every cell of its tree each period, and any cell hears four ticks a
 * millisecond. As long as nothing is due and no state changes but that of the queues, such an input needs none of the
 * questions that a step asks otherwise; how long that is, the long way finds out when it ends. Both ways do the same:
 * what a frame does here it would do there, and nothing else. */
#ifndef ROBOTSKIN_CELL_FAST_PATH_H
#define ROBOTSKIN_CELL_FAST_PATH_H

#include <string.h>

#include "cell/time/tick_time.h"
#include "cell/transmit.h"
#include "cell/transport/arq_sender.h"
#include "cell/transport/queues.h"
#include "cell/transport/rings.h"
#include "cell/wire/ports.h"
#include "cell/wire/wave.h"
#include "robotskin/arq_receiver.h"
#include "robotskin/cell.h"
#include "robotskin/crc.h"

/* A sample of the subtree joins those that wait for the parent. */
RS_INLINE bool take_sample(rs_cell* cell, rs_neighbour* neighbour, const uint8_t* frame, bool checked,
                           uint32_t now_us) {
  rs_queues* queues = &cell->queues;
  if (!rs_sample_has_hop(frame) || queues->data.count >= queues->data_most || rs_frame_is_retransmitted(frame))
    return false;
  if (!checked && !rs_frame_intact(frame)) return false;
  neighbour->heard_us = now_us;
  uint8_t* place = rs_ring_place(&queues->data, queues->data_frame, RS_QUEUE_DATA);
  rs_samples_sent_within(queues);
  rs_sample_bring(place, frame);
  queues->waiting |= queues->parent_bit;
  return true;
}

/* Whether a tick is of the wave that this cell passes on. */
static bool of_own_wave(const rs_route* route, const rs_tick* tick) {
  const rs_wave* wave = &route->wave;
  return tick->tag == wave->tag && tick->sequence == wave->sequence && tick->era == wave->era &&
         tick->root == wave->root && tick->forming == wave->forming && tick->depth_cap == wave->depth_cap &&
         tick->rate_divisor == wave->rate_divisor && tick->gain_threshold == wave->gain_threshold;
}

/* Whether it tells nothing new of a neighbour that is there, but that it is there. */
static bool as_before(const rs_neighbour* neighbour, const rs_tick* tick) {
  return tick->hops == neighbour->hops && tick->hops != RS_HOPS_POISON && tick->sender == neighbour->id &&
         tick->sender_port + 1U == neighbour->port && tick->nonce == neighbour->nonce && tick->heard != 0U &&
         neighbour->hears_us && neighbour->met && !neighbour->lagging &&
         (tick->parent != 0U) == (neighbour->child != 0U) && (tick->draining != 0U) == (neighbour->draining != 0U);
}

/* Whether a neighbour with the own wave could become the parent. */
static bool could_be_parent(const rs_route* route, const rs_neighbour* neighbour) {
  if (neighbour->child) return false;
  return route->handover || route->neighbour[(route->parent_port - 1U) % RS_PORTS].draining || route->unbound ||
         route->wave.sequence != route->feasible_sequence || neighbour->hops < route->feasible_hops;
}

/* A tick of a neighbour that is not the parent, about a wave that is known to be a root's. */
static RS_NOINLINE RS_HOT bool take_tick(rs_cell* cell, unsigned port, const uint8_t* frame, bool checked,
                                         uint32_t now_us) {
  rs_route* route = &cell->route;
  rs_neighbour* neighbour = &route->neighbour[port];
  rs_tick tick;
  rs_tick_unpack(&tick, frame);
  if (!of_own_wave(route, &tick) || !as_before(neighbour, &tick) || could_be_parent(route, neighbour)) return false;
  if (tick.parent != 0U && !rs_arq_receiver_agrees(&neighbour->arq_receiver, tick.ack)) return false;
  const uint32_t time = rs_wave_time(&route->wave);
  const uint32_t ahead = rs_ticks_between(rs_wave_time(&neighbour->wave), time);
  if (ahead >= RS_TICK_TIME_HALF || time != route->known_time || time != ~route->known_time_complement ||
      route->in_quarantine || route->wave.root == 0U || neighbour->wave.root != route->wave.root) {
    return false;
  }
  if (!checked && !rs_frame_intact(frame)) return false;
  neighbour->heard_us = now_us;
  if (tick.parent != 0U) rs_arq_receiver_agree(&neighbour->arq_receiver);
  if (!rs_waves_equal(&route->wave, &neighbour->wave)) {
    neighbour->turned_us = now_us;
    neighbour->stale = false;
  }
  neighbour->wave = route->wave;
  neighbour->origin_us = now_us - RS_FRAME_US - RS_AGE_STEP_US * tick.age_4us;
  return true;
}

/* Takes a frame as the long way would; false, and nothing changed, if it asks for that. */
RS_INLINE bool take_frame(rs_cell* cell, unsigned from, const uint8_t* frame, bool checked, uint32_t now_us) {
  const unsigned port = from - 1U;
  if (port >= RS_PORTS || from == cell->queues.parent_port) return false;
  rs_neighbour* neighbour = &cell->route.neighbour[port];
  if (now_us - neighbour->heard_us >= RS_LINK_DOWN_US || !neighbour->up) return false;
  switch (rs_frame_type_of(frame)) {
    case RS_TYPE_clock:
    case RS_TYPE_further:
      return take_sample(cell, neighbour, frame, checked, now_us);
    case RS_TYPE_tick:
      return take_tick(cell, port, frame, checked, now_us);
    default:
      return false;
  }
}

/* Whether a frame came from below, over a line that has been up. */
RS_INLINE bool came_from_below(const rs_cell* cell, unsigned from, uint32_t now_us) {
  if (from - 1U >= RS_PORTS || from == cell->queues.parent_port) return false;
  const rs_neighbour* neighbour = &cell->route.neighbour[from - 1U];
  return now_us - neighbour->heard_us < RS_LINK_DOWN_US && neighbour->up;
}

/* An event of the subtree joins those that wait for the parent, which may ask for it again. */
static RS_NOINLINE RS_HOT bool take_event(rs_cell* cell, unsigned from, const uint8_t* frame, bool checked,
                                          uint32_t now_us) {
  rs_arq_sender* arq_sender = &cell->arq_sender;
  if (!came_from_below(cell, from, now_us) || arq_sender->event.count >= RS_ARQ_EVENTS || !rs_sample_has_hop(frame) ||
      rs_frame_is_retransmitted(frame) || (!checked && !rs_frame_intact(frame)))
    return false;
  rs_neighbour* neighbour = &cell->route.neighbour[from - 1U];
  neighbour->heard_us = now_us;
  rs_arq_receiver_count(&neighbour->arq_receiver);
  const unsigned place = (arq_sender->event.first + arq_sender->event.count++) & (RS_ARQ_EVENTS - 1U);
  const uint32_t age_us = cell->route.timed ? rs_sample_age_us(cell, frame, now_us) : 0U;
  arq_sender->event_time[place] = rs_arq_coarse(now_us - age_us);
  rs_sample_bring(arq_sender->event_frame[place], frame);
  cell->queues.samples_next = false;
  cell->queues.waiting |= cell->queues.parent_bit;
  return true;
}

/* The same for any event, report or request of the subtree. */
static RS_NOINLINE bool take_report(rs_cell* cell, unsigned from, const uint8_t* received, bool checked,
                                    uint32_t now_us) {
  enum { UP = 1 << RS_TYPE_event | 1 << RS_TYPE_topology | 1 << RS_TYPE_reply | 1 << RS_TYPE_join };
  const rs_frame_type type = rs_frame_type_of(received);
  if (((unsigned)UP >> type & 1U) == 0U) return false;
  if (type == RS_TYPE_event && take_event(cell, from, received, checked, now_us)) return true;
  if (!came_from_below(cell, from, now_us)) return false;
  RS_WORDS uint8_t frame[RS_FRAME_BYTES];
  rs_frame_copy(frame, (const uint8_t*)RS_AT_WORD(received));
  if ((!checked && !rs_frame_intact(frame)) || !rs_frame_take_hop(frame)) return false;
  rs_neighbour* neighbour = &cell->route.neighbour[from - 1U];
  neighbour->heard_us = now_us;
  if (type == RS_TYPE_event) rs_arq_receiver_count(&neighbour->arq_receiver);
  rs_queue_up(cell, frame, now_us);
  if (type == RS_TYPE_event || cell->queues.passed_over >= RS_SLOW_SHARE) cell->queues.samples_next = false;
  if (rs_cell_waiting(cell) > 0U) cell->queues.waiting |= cell->queues.parent_bit;
  return true;
}

/* Ports on which something can go out. */
RS_INLINE unsigned ready_to_send(const rs_queues* queues) {
  return queues->waiting & ~(unsigned)queues->busy & RS_ALL_PORTS;
}

/* Whether that is a sample to the parent. */
RS_INLINE bool is_sample(const rs_queues* queues, unsigned ready) {
  return ready == queues->parent_bit && queues->samples_next && queues->data.count != 0U;
}

/* The oldest sample goes out to the parent; on which port, and where it stands. */
RS_INLINE unsigned send_sample(rs_queues* queues, uint32_t now_us, const uint8_t** frame) {
  const unsigned port = (queues->parent_port - 1U) % RS_PORTS;
  queues->busy |= queues->parent_bit;
  queues->data_passed_over = 0;
  if (queues->slow.count != 0U && ++queues->passed_over >= RS_SLOW_SHARE) queues->samples_next = false;
  queues->started_us[port] = now_us;
  uint8_t* place = rs_sending_next(queues, port);
  rs_samples_take(queues, now_us, place);
  rs_sending_turn(queues, port);
  if ((queues->data.count | queues->slow.count | queues->down.count) == 0U) queues->waiting = queues->beacon_due;
  *frame = place;
  return port;
}

/* The next event goes out to the parent; 0: something else may wait, or it has been sent before, or is of no use. */
static RS_NOINLINE unsigned send_event(rs_cell* cell, unsigned ready, uint32_t now_us) {
  rs_queues* queues = &cell->queues;
  rs_arq_sender* arq_sender = &cell->arq_sender;
  rs_arq_ring* ring = &arq_sender->event;
  if (ready != queues->parent_bit || ring->sent >= ring->count || (queues->beacon_due & ready) != 0U ||
      (queues->status_due | queues->slow.count | queues->data.count | queues->data_again | queues->down.count) != 0U ||
      !rs_arq_torques_rest(arq_sender, now_us))
    return 0;
  if (rs_arq_is_old(arq_sender, 0, now_us)) rs_arq_drop_old_events(cell, now_us);
  const unsigned sent = ring->sent;
  if (sent >= ring->count || sent < ring->tried || rs_arq_is_old(arq_sender, sent, now_us)) return 0;
  const unsigned port = (queues->parent_port - 1U) % RS_PORTS;
  rs_frame_copy(rs_sending_next(queues, port), arq_sender->event_frame[(ring->first + sent) & (RS_ARQ_EVENTS - 1U)]);
  rs_sending_turn(queues, port);
  ring->sent = ring->tried = (uint8_t)(sent + 1U);
  arq_sender->number = (uint8_t)((arq_sender->number + 1U) & RS_NUMBER_MASK);
  queues->data_passed_over = 0;
  queues->busy |= (uint8_t)ready;
  queues->started_us[port] = now_us;
  queues->samples_next = sent + 1U >= ring->count;
  queues->waiting = (uint8_t)(queues->beacon_due | (queues->samples_next ? 0U : ready));
  return ready;
}

/* Whatever is next goes out on these ports; on which something does. */
static RS_NOINLINE unsigned send_anything(rs_cell* cell, unsigned ready, uint32_t now_us) {
  unsigned started = send_event(cell, ready, now_us);
  if (started != 0U) return started;
  started = rs_transmit_start(cell, ready, now_us);
  cell->queues.waiting = (uint8_t)rs_transmit_wanted(cell);
  cell->queues.samples_next = rs_samples_next(cell);
  return started;
}

/* Whether nothing is due. */
RS_INLINE bool calm(const rs_cell* cell, uint32_t now_us) {
  return cell->queues.calm_us - now_us - 1U < RS_HEARTBEAT_US;
}

/* Frames that are out (bit p: port p), as `sent` of the input that comes next. */
RS_INLINE void rs_note_sent(rs_cell* cell, unsigned sent) {
  cell->queues.busy &= (uint8_t)~sent;
}

#endif
