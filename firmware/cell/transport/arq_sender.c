/* SPDX-License-Identifier: Apache-2.0
 * Copies of events and torque sums that were sent and may be asked for again (see robotskin/arq_sender.h). */
#include "cell/transport/arq_sender.h"

#include <string.h>

#include "cell/memory/integrity.h"
#include "cell/time/tick_time.h"
#include "cell/wire/frame_copy.h"
#include "robotskin/arq_sender.h"
#include "robotskin/crc.h"

enum { EVENT_MASK = RS_ARQ_EVENTS - 1, TORQUE_MASK = RS_ARQ_TORQUES - 1 };

static void drop_first(rs_arq_ring* ring, unsigned mask) {
  ring->first = (uint8_t)((ring->first + 1U) & mask);
  --ring->count;
  if (ring->sent > 0U) --ring->sent;
  if (ring->confirmed > 0U) --ring->confirmed;
  if (ring->tried > 0U) --ring->tried;
}

static void drop_first_event(rs_cell* cell) {
  rs_arq_sender* arq_sender = &cell->arq_sender;
  if (arq_sender->event.tried == 0U) {
    ++cell->counts.frames_dropped;
    cell->sampling.dropped = true;
  }
  drop_first(&arq_sender->event, EVENT_MASK);
  for (unsigned i = 0; i < arq_sender->announcements; ++i) {
    if (arq_sender->announced[i].events > 0U) --arq_sender->announced[i].events;
  }
}

static void drop_first_torque(rs_arq_sender* arq_sender) {
  drop_first(&arq_sender->torque, TORQUE_MASK);
  for (unsigned i = 0; i < arq_sender->announcements; ++i) {
    if (arq_sender->announced[i].torques > 0U) --arq_sender->announced[i].torques;
  }
}

/* Drops what is too old: an event because the host could not tell its time any more, a torque sum because its epoch is
 * over or because a parent that rebooted could have forgotten that it had it. */
void rs_arq_drop_old_events(rs_cell* cell, uint32_t now_us) {
  const rs_arq_sender* arq_sender = &cell->arq_sender;
  rs_cell_hold_indices(cell);
  while (arq_sender->event.count > 0U && rs_arq_is_old(arq_sender, 0, now_us)) drop_first_event(cell);
}

static void prune(rs_cell* cell, uint32_t now_us) {
  rs_arq_sender* arq_sender = &cell->arq_sender;
  if (arq_sender->event.count > 0U && rs_arq_is_old(arq_sender, 0, now_us)) rs_arq_drop_old_events(cell, now_us);
  while (arq_sender->torque.count > 0U) {
    const uint32_t age = rs_arq_age_us(arq_sender->torque_time[arq_sender->torque.first & TORQUE_MASK], now_us);
    if (age <= (arq_sender->torque.tried > 0U ? RS_TORQUE_RETRY_US : RS_TORQUE_LATE_US)) break;
    drop_first_torque(arq_sender);
  }
}

/* Whether one of so many frames in a row is of the same cell and as old, the last ones first: they are what the lower
 * end of a line sends again. All that a crowded cell hears may ask for this. */
static bool is_among(const uint8_t (*frames)[RS_FRAME_BYTES], unsigned count, uint32_t first_word) {
  enum { OTHER_BITS = 31 - RS_event_sequence_LAST };
  const uint8_t (*frame)[RS_FRAME_BYTES] = frames + count;
  while (frame != frames) {
    --frame;
    if ((rs_frame_word(*frame, 0) ^ first_word) >> OTHER_BITS == 0U) return true;
  }
  return false;
}

static bool is_here(const rs_arq_sender* arq_sender, const uint8_t* frame) {
  const uint32_t first_word = rs_load32(frame);
  const unsigned first = arq_sender->event.first & EVENT_MASK, to_end = RS_ARQ_EVENTS - first;
  const unsigned count = arq_sender->event.count < RS_ARQ_EVENTS ? arq_sender->event.count : RS_ARQ_EVENTS;
  const unsigned straight = count < to_end ? count : to_end;
  return is_among(arq_sender->event_frame, count - straight, first_word) ||
         is_among(arq_sender->event_frame + first, straight, first_word);
}

bool rs_arq_sender_event(rs_cell* cell, const uint8_t* frame, uint32_t now_us) {
  rs_arq_sender* arq_sender = &cell->arq_sender;
  if (rs_frame_is_retransmitted(frame) && is_here(arq_sender, frame)) return true;
  if (arq_sender->event.count >= RS_ARQ_EVENTS) {
    if (arq_sender->event.tried == 0U) return false;
    drop_first_event(cell);
  }
  const unsigned place = (arq_sender->event.first + arq_sender->event.count++) & EVENT_MASK;
  arq_sender->event_time[place] =
      rs_arq_coarse(now_us - (cell->route.timed ? rs_sample_age_us(cell, frame, now_us) : 0U));
  rs_frame_copy(arq_sender->event_frame[place], frame);
  return true;
}

bool rs_arq_sender_torque(rs_cell* cell, const rs_torque* torque, uint32_t now_us) {
  rs_arq_sender* arq_sender = &cell->arq_sender;
  if (arq_sender->torque.count >= RS_ARQ_TORQUES) {
    if (arq_sender->torque.tried == 0U) return false;
    drop_first_torque(arq_sender);
  }
  const unsigned place = (arq_sender->torque.first + arq_sender->torque.count++) & TORQUE_MASK;
  rs_torque numbered = *torque;
  numbered.type = RS_TYPE_torque;
  numbered.serial = arq_sender->torque_serial++ & RS_SERIAL_MASK;
  arq_sender->torque_time[place] = rs_arq_coarse(now_us);
  rs_torque_pack(arq_sender->torque_frame[place], &numbered);
  rs_frame_seal(arq_sender->torque_frame[place]);
  return true;
}

static void note_sent(rs_arq_sender* arq_sender, rs_arq_ring* ring) {
  ++ring->sent;
  if (ring->tried < ring->sent) ring->tried = ring->sent;
  arq_sender->number = (uint8_t)((arq_sender->number + 1U) & RS_NUMBER_MASK);
}

bool rs_arq_sender_torque_waits(const rs_cell* cell) {
  return cell->arq_sender.torque.sent < cell->arq_sender.torque.count;
}

bool rs_arq_sender_next_torque(rs_cell* cell, uint8_t* frame, uint32_t now_us) {
  rs_arq_sender* arq_sender = &cell->arq_sender;
  rs_arq_ring* ring = &arq_sender->torque;
  if (ring->sent >= ring->count) return false;
  prune(cell, now_us);
  if (ring->sent >= ring->count) return false;
  rs_frame_copy(frame, arq_sender->torque_frame[(ring->first + ring->sent) & TORQUE_MASK]);
  if (!rs_frame_intact(frame)) { /* damaged memory: it would be sent again and again */
    *ring = (rs_arq_ring){0};
    arq_sender->announcements = 0;
    return false;
  }
  note_sent(arq_sender, ring);
  return true;
}

static bool is_of_use(const rs_arq_sender* arq_sender, unsigned at, bool again, uint32_t now_us) {
  return rs_arq_age_us(arq_sender->event_time[at & EVENT_MASK], now_us) <= RS_ARQ_KEEP_US &&
         (!again || rs_frame_intact(arq_sender->event_frame[at & EVENT_MASK]));
}

/* Drops the next event to send while it is too old, as events of other cells may have come before it that are not, or
 * sent before and damaged in memory: it would be sent again and again. */
static void skip_useless_events(rs_cell* cell, uint32_t now_us) {
  rs_arq_sender* arq_sender = &cell->arq_sender;
  rs_arq_ring* ring = &arq_sender->event;
  while (ring->sent < ring->count &&
         !is_of_use(arq_sender, ring->first + ring->sent, ring->sent < ring->tried, now_us)) {
    if (ring->tried > ring->sent) {
      --ring->tried;
    } else {
      ++cell->counts.frames_dropped;
      cell->sampling.dropped = true;
    }
    --ring->count;
    for (unsigned i = ring->sent; i < ring->count; ++i) {
      const unsigned to = (ring->first + i) & EVENT_MASK, from = (to + 1U) & EVENT_MASK;
      arq_sender->event_time[to] = arq_sender->event_time[from];
      memcpy(arq_sender->event_frame[to], arq_sender->event_frame[from], RS_FRAME_BYTES);
    }
  }
}

bool rs_arq_sender_next_event(rs_cell* cell, uint8_t* frame, uint32_t now_us) {
  rs_arq_sender* arq_sender = &cell->arq_sender;
  rs_arq_ring* ring = &arq_sender->event;
  if (ring->sent >= ring->count) return false;
  prune(cell, now_us);
  skip_useless_events(cell, now_us);
  if (ring->sent >= ring->count) return false;
  rs_frame_copy(frame, arq_sender->event_frame[(ring->first + ring->sent) & EVENT_MASK]);
  if (ring->sent < ring->tried) rs_frame_mark_retransmitted(frame);
  note_sent(arq_sender, ring);
  return true;
}

uint32_t rs_arq_sender_announce(rs_cell* cell) {
  rs_arq_sender* arq_sender = &cell->arq_sender;
  const rs_announcement now = {arq_sender->number, arq_sender->event.sent, arq_sender->torque.sent};
  rs_announcement* list = arq_sender->announced;
  if (arq_sender->announcements > 0U && list[arq_sender->announcements - 1U].number == now.number) return now.number;
  if (arq_sender->announcements == RS_ANNOUNCEMENTS) {
    memmove(list, list + 1, (RS_ANNOUNCEMENTS - 1U) * sizeof *list);
    --arq_sender->announcements;
  }
  list[arq_sender->announcements++] = now;
  return now.number;
}

static void confirm(rs_arq_sender* arq_sender, uint8_t number) {
  unsigned known = 0;
  while (known < arq_sender->announcements && arq_sender->announced[known].number != number) ++known;
  if (known == arq_sender->announcements) return;
  arq_sender->event.confirmed = arq_sender->announced[known].events;
  arq_sender->torque.confirmed = arq_sender->announced[known].torques;
  /* It stays on the list: the same number may be confirmed again and again while nothing is sent. */
  arq_sender->announcements = (uint8_t)(arq_sender->announcements - known);
  memmove(arq_sender->announced, arq_sender->announced + known,
          arq_sender->announcements * sizeof arq_sender->announced[0]);
  while (arq_sender->torque.confirmed > 0U) drop_first_torque(arq_sender);
}

static void take_ack(rs_cell* cell, uint32_t ack, uint32_t now_us) {
  rs_arq_sender* arq_sender = &cell->arq_sender;
  const uint8_t number = (uint8_t)(ack & RS_NUMBER_MASK);
  confirm(arq_sender, number);
  if ((ack & RS_ARQ_MISSED) == 0U) return;
  /* The parent may not have heard yet that this cell has gone back. */
  if (now_us - arq_sender->back_us < RS_ARQ_BACK_US) return;
  arq_sender->back_us = now_us;
  arq_sender->event.sent = arq_sender->event.confirmed;
  arq_sender->torque.sent = arq_sender->torque.confirmed;
  arq_sender->number = number;
  arq_sender->announcements = 0;
  cell->queues.beacon_due |= (uint8_t)(1U << ((cell->route.parent_port - 1U) % RS_PORTS));
}

static void check_ring(rs_arq_ring* ring, unsigned size) {
  if (ring->count > size || ring->tried > ring->count || ring->sent > ring->tried || ring->confirmed > ring->sent) {
    *ring = (rs_arq_ring){0};
  }
}

void rs_arq_sender_check(rs_cell* cell, uint32_t now_us) {
  rs_arq_sender* arq_sender = &cell->arq_sender;
  check_ring(&arq_sender->event, RS_ARQ_EVENTS);
  check_ring(&arq_sender->torque, RS_ARQ_TORQUES);
  if (arq_sender->announcements > RS_ANNOUNCEMENTS) arq_sender->announcements = 0;
  for (unsigned i = 0; i < arq_sender->announcements; ++i) {
    const rs_announcement* entry = &arq_sender->announced[i];
    if (entry->events > arq_sender->event.sent || entry->torques > arq_sender->torque.sent)
      arq_sender->announcements = 0;
  }
  prune(cell, now_us);
}

bool rs_arq_missed(rs_cell* cell, unsigned port, uint32_t number, uint32_t late_us) {
  rs_arq_receiver* arq_receiver = &cell->route.neighbour[port].arq_receiver;
  const uint8_t next = arq_receiver->next;
  if (!rs_arq_receiver_compare(arq_receiver, number)) return false;
  /* Frames that the processor had no time for would find it no sooner if they came again, and take that of others. */
  const bool crowded = cell->arq_sender.event.count >= RS_ARQ_CROWDED && cell->torque.reports[port] == 0U;
  if (!crowded && late_us < RS_ARQ_LATE_US) return true;
  cell->counts.frames_dropped += (number - next) & RS_NUMBER_MASK;
  cell->sampling.dropped = true;
  rs_arq_receiver_give_up(arq_receiver, number);
  return false;
}

void rs_arq_sender_tick(rs_cell* cell, unsigned port, const rs_tick* tick, bool was_child, uint32_t came_us,
                        uint32_t now_us) {
  rs_arq_receiver* arq_receiver = &cell->route.neighbour[port].arq_receiver;
  if (tick->parent == 0U) {
    arq_receiver->kept = false;
    if (port + 1U == cell->route.parent_port) take_ack(cell, tick->ack, now_us);
  } else if (!was_child && !arq_receiver->kept) {
    rs_arq_receiver_start(arq_receiver, tick->ack);
  } else if (rs_arq_missed(cell, port, tick->ack, now_us - came_us)) {
    cell->queues.beacon_due |= (uint8_t)(1U << port);
  }
}
