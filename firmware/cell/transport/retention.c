/* SPDX-License-Identifier: Apache-2.0
 * Copies of events and torque sums that were sent and may be asked for again (see robotskin/retention.h). */
#include "cell/transport/retention.h"

#include <string.h>

#include "cell/time/tick_time.h"
#include "robotskin/crc.h"
#include "robotskin/retention.h"

enum {
  EVENT_MASK = RS_RETAINED_EVENTS - 1,
  TORQUE_MASK = RS_RETAINED_TORQUES - 1,
  IDENTITY_MASK = (int)0xFFFFFFC0 /* of a frame's first word: type, source and sequence */
};

static uint16_t coarse(uint32_t now_us) {
  return (uint16_t)(now_us >> 6);
}

static uint32_t age_us(uint16_t time, uint32_t now_us) {
  return (uint32_t)(uint16_t)(coarse(now_us) - time) << 6;
}

static void drop_first(rs_retained* ring, unsigned mask) {
  ring->first = (uint8_t)((ring->first + 1U) & mask);
  --ring->count;
  if (ring->sent > 0U) --ring->sent;
  if (ring->confirmed > 0U) --ring->confirmed;
  if (ring->tried > 0U) --ring->tried;
}

static void drop_first_event(rs_cell* cell) {
  rs_retention* retention = &cell->retention;
  if (retention->event.tried == 0U) {
    ++cell->counts.frames_dropped;
    cell->sampling.dropped = true;
  }
  drop_first(&retention->event, EVENT_MASK);
  for (unsigned i = 0; i < retention->announcements; ++i) {
    if (retention->announced[i].events > 0U) --retention->announced[i].events;
  }
}

static void drop_first_torque(rs_retention* retention) {
  drop_first(&retention->torque, TORQUE_MASK);
  for (unsigned i = 0; i < retention->announcements; ++i) {
    if (retention->announced[i].torques > 0U) --retention->announced[i].torques;
  }
}

/* Drops what is too old: an event because the host could not tell its time any more, a torque sum because its epoch is
 * over or because a parent that rebooted could have forgotten that it had it. */
static void prune(rs_cell* cell, uint32_t now_us) {
  rs_retention* retention = &cell->retention;
  while (retention->event.count > 0U &&
         age_us(retention->event_time[retention->event.first & EVENT_MASK], now_us) > RS_RETENTION_US) {
    drop_first_event(cell);
  }
  while (retention->torque.count > 0U) {
    const uint32_t age = age_us(retention->torque_time[retention->torque.first & TORQUE_MASK], now_us);
    if (age <= (retention->torque.tried > 0U ? RS_TORQUE_RETRY_US : RS_TORQUE_LATE_US)) break;
    drop_first_torque(retention);
  }
}

static bool is_here(const rs_retention* retention, const uint8_t* frame) {
  const uint32_t identity = rs_load32(frame) & (uint32_t)IDENTITY_MASK;
  for (unsigned i = 0; i < retention->event.count; ++i) {
    const uint8_t* kept = retention->event_frame[(retention->event.first + i) & EVENT_MASK];
    if ((rs_load32(kept) & (uint32_t)IDENTITY_MASK) == identity) return true;
  }
  return false;
}

bool rs_retention_event(rs_cell* cell, const uint8_t* frame, uint32_t now_us) {
  rs_retention* retention = &cell->retention;
  if (rs_frame_is_replayed(frame) && is_here(retention, frame)) return true;
  if (retention->event.count >= RS_RETAINED_EVENTS) {
    if (retention->event.tried == 0U) return false;
    drop_first_event(cell);
  }
  const unsigned place = (retention->event.first + retention->event.count++) & EVENT_MASK;
  retention->event_time[place] = coarse(now_us - (cell->route.timed ? rs_sample_age_us(cell, frame, now_us) : 0U));
  memcpy(retention->event_frame[place], frame, RS_FRAME_BYTES);
  return true;
}

bool rs_retention_torque(rs_cell* cell, const rs_torque* torque, uint32_t now_us) {
  rs_retention* retention = &cell->retention;
  if (retention->torque.count >= RS_RETAINED_TORQUES) {
    if (retention->torque.tried == 0U) return false;
    drop_first_torque(retention);
  }
  const unsigned place = (retention->torque.first + retention->torque.count++) & TORQUE_MASK;
  rs_torque numbered = *torque;
  numbered.type = RS_TYPE_torque;
  numbered.serial = retention->torque_serial++ & RS_SERIAL_MASK;
  retention->torque_time[place] = coarse(now_us);
  rs_torque_pack(retention->torque_frame[place], &numbered);
  rs_frame_seal(retention->torque_frame[place]);
  return true;
}

static void note_sent(rs_retention* retention, rs_retained* ring) {
  ++ring->sent;
  if (ring->tried < ring->sent) ring->tried = ring->sent;
  retention->number = (uint8_t)((retention->number + 1U) & RS_NUMBER_MASK);
}

bool rs_retention_torque_waits(const rs_cell* cell) {
  return cell->retention.torque.sent < cell->retention.torque.count;
}

bool rs_retention_next_torque(rs_cell* cell, uint8_t* frame, uint32_t now_us) {
  rs_retention* retention = &cell->retention;
  rs_retained* ring = &retention->torque;
  if (ring->sent >= ring->count) return false;
  prune(cell, now_us);
  if (ring->sent >= ring->count) return false;
  memcpy(frame, retention->torque_frame[(ring->first + ring->sent) & TORQUE_MASK], RS_FRAME_BYTES);
  if (!rs_frame_intact(frame)) { /* damaged memory: it would be sent again and again */
    *ring = (rs_retained){0};
    retention->announcements = 0;
    return false;
  }
  note_sent(retention, ring);
  return true;
}

static bool is_of_use(const rs_retention* retention, unsigned at, uint32_t now_us) {
  return age_us(retention->event_time[at & EVENT_MASK], now_us) <= RS_RETENTION_US &&
         rs_frame_intact(retention->event_frame[at & EVENT_MASK]);
}

/* Drops the next event to send while it is too old, as events of other cells may have come before it that are not, or
 * damaged in memory: it would be sent again and again. */
static void skip_useless_events(rs_cell* cell, uint32_t now_us) {
  rs_retention* retention = &cell->retention;
  rs_retained* ring = &retention->event;
  while (ring->sent < ring->count && !is_of_use(retention, ring->first + ring->sent, now_us)) {
    if (ring->tried > ring->sent) {
      --ring->tried;
    } else {
      ++cell->counts.frames_dropped;
      cell->sampling.dropped = true;
    }
    --ring->count;
    for (unsigned i = ring->sent; i < ring->count; ++i) {
      const unsigned to = (ring->first + i) & EVENT_MASK, from = (to + 1U) & EVENT_MASK;
      retention->event_time[to] = retention->event_time[from];
      memcpy(retention->event_frame[to], retention->event_frame[from], RS_FRAME_BYTES);
    }
  }
}

bool rs_retention_next_event(rs_cell* cell, uint8_t* frame, uint32_t now_us) {
  rs_retention* retention = &cell->retention;
  rs_retained* ring = &retention->event;
  if (ring->sent >= ring->count) return false;
  prune(cell, now_us);
  skip_useless_events(cell, now_us);
  if (ring->sent >= ring->count) return false;
  memcpy(frame, retention->event_frame[(ring->first + ring->sent) & EVENT_MASK], RS_FRAME_BYTES);
  if (ring->sent < ring->tried) rs_frame_mark_replayed(frame);
  note_sent(retention, ring);
  return true;
}

uint32_t rs_retention_announce(rs_cell* cell) {
  rs_retention* retention = &cell->retention;
  const rs_announcement now = {retention->number, retention->event.sent, retention->torque.sent};
  rs_announcement* list = retention->announced;
  if (retention->announcements > 0U && list[retention->announcements - 1U].number == now.number) return now.number;
  if (retention->announcements == RS_ANNOUNCEMENTS) {
    memmove(list, list + 1, (RS_ANNOUNCEMENTS - 1U) * sizeof *list);
    --retention->announcements;
  }
  list[retention->announcements++] = now;
  return now.number;
}

static void confirm(rs_retention* retention, uint8_t number) {
  unsigned known = 0;
  while (known < retention->announcements && retention->announced[known].number != number) ++known;
  if (known == retention->announcements) return;
  retention->event.confirmed = retention->announced[known].events;
  retention->torque.confirmed = retention->announced[known].torques;
  /* It stays on the list: the same number may be confirmed again and again while nothing is sent. */
  retention->announcements = (uint8_t)(retention->announcements - known);
  memmove(retention->announced, retention->announced + known,
          retention->announcements * sizeof retention->announced[0]);
  while (retention->torque.confirmed > 0U) drop_first_torque(retention);
}

static void take_echo(rs_cell* cell, uint32_t echo, uint32_t now_us) {
  rs_retention* retention = &cell->retention;
  const uint8_t number = (uint8_t)(echo & RS_NUMBER_MASK);
  confirm(retention, number);
  if ((echo & RS_ECHO_MISSED) == 0U) return;
  /* The parent may not have heard yet that this cell has gone back. */
  if (now_us - retention->back_us < RS_ECHO_US) return;
  retention->back_us = now_us;
  retention->event.sent = retention->event.confirmed;
  retention->torque.sent = retention->torque.confirmed;
  retention->number = number;
  retention->announcements = 0;
  cell->queues.advert_due |= (uint8_t)(1U << ((cell->route.parent_port - 1U) % RS_PORTS));
}

static void check_ring(rs_retained* ring, unsigned size) {
  if (ring->count > size || ring->tried > ring->count || ring->sent > ring->tried || ring->confirmed > ring->sent) {
    *ring = (rs_retained){0};
  }
}

void rs_retention_check(rs_cell* cell, uint32_t now_us) {
  rs_retention* retention = &cell->retention;
  check_ring(&retention->event, RS_RETAINED_EVENTS);
  check_ring(&retention->torque, RS_RETAINED_TORQUES);
  if (retention->announcements > RS_ANNOUNCEMENTS) retention->announcements = 0;
  for (unsigned i = 0; i < retention->announcements; ++i) {
    const rs_announcement* entry = &retention->announced[i];
    if (entry->events > retention->event.sent || entry->torques > retention->torque.sent) retention->announcements = 0;
  }
  prune(cell, now_us);
}

void rs_retention_tick(rs_cell* cell, unsigned port, const rs_tick* tick, bool was_child, uint32_t now_us) {
  rs_hearing* hearing = &cell->route.neighbour[port].hearing;
  if (tick->parent == 0U) {
    hearing->kept = false;
    if (port + 1U == cell->route.parent_port) take_echo(cell, tick->echo, now_us);
  } else if (!was_child && !hearing->kept) {
    rs_hearing_start(hearing, tick->echo);
  } else if (rs_hearing_compare(hearing, tick->echo)) {
    cell->queues.advert_due |= (uint8_t)(1U << port);
  }
}
