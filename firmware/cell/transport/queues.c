/* SPDX-License-Identifier: Apache-2.0
 * Frames that wait: samples and reports for the parent, commands for the children. */
#include "cell/transport/queues.h"

#include <stddef.h>
#include <string.h>

#include "cell/time/sample_clock.h"
#include "cell/time/tick_time.h"
#include "cell/transport/arq_sender.h"
#include "cell/transport/rings.h"
#include "cell/wire/frame_copy.h"
#include "robotskin/crc.h"

enum {
  LOSSY_AT_ONCE = 8, /* samples that wait while some are repeated */
  SENT_FEW = 8,      /* samples sent lately that are all repeated; of more, every other one */
  REPEAT_TICKS = 4,  /* for which every other one is left out after that, too */
  PERIOD_US = 1000000 / RS_CLOCK_RATE_DEFAULT_HZ
};

/* Where the queue is full, a report or request that waits is replaced by a newer one of the same cell. */
static uint8_t* replaceable(rs_queues* queues, const uint8_t* frame) {
  const rs_frame_type type = rs_frame_type_of(frame);
  if (type != RS_TYPE_topology && type != RS_TYPE_join) return NULL;
  const uint32_t mask = type == RS_TYPE_join ? 0xFFFFFFFFU : ~0U << (32U - RS_topology_uid_AT);
  const uint8_t mask_5 = type == RS_TYPE_join ? 0xF0U : 0U; /* the last bits of a serial number */
  for (unsigned i = 0; i < queues->slow.count; ++i) {
    uint8_t* waiting = queues->slow_frame[(queues->slow.first + i) & (RS_QUEUE_SLOW - 1U)];
    if (((rs_load32(waiting) ^ rs_load32(frame)) & mask) == 0U && ((waiting[4] ^ frame[4]) & mask_5) == 0U) {
      return waiting;
    }
  }
  return NULL;
}

/* Whether a sample waits or has been sent lately. Where all of a subtree looks for its way, several cells repeat what
 * they have sent, one to the other. */
static bool is_here(const rs_queues* queues, const uint8_t* frame) {
  const uint32_t mask = ~0U << (31U - RS_clock_sequence_LAST); /* type, source and sequence */
  const unsigned count = (unsigned)queues->data.count + queues->data_sent;
  for (unsigned i = 0, at = queues->data.first - queues->data_sent; i < count; ++i, ++at) {
    const uint8_t* other = queues->data_frame[at & (RS_QUEUE_DATA - 1U)];
    if (((rs_load32(other) ^ rs_load32(frame)) & mask) == 0U) return true;
  }
  return false;
}

bool rs_queue_up(rs_cell* cell, const uint8_t* frame, uint32_t now_us) {
  rs_queues* queues = &cell->queues;
  uint8_t* place = NULL;
  switch (rs_frame_type_of(frame)) {
    case RS_TYPE_event:
      if (rs_arq_sender_event(cell, frame, now_us)) return true;
      cell->sampling.dropped = true;
      break;
    case RS_TYPE_clock:
    case RS_TYPE_further:
      if (rs_frame_is_retransmitted(frame) && is_here(queues, frame)) return true;
      if (queues->data.count >= queues->data_most && rs_sampling_left_out(cell, frame, now_us)) {
        ++cell->counts.frames_dropped;
        /* While more cells have just come than a line carries, the section unit knows better what to do. */
        if (queues->data_most >= RS_QUEUE_DATA) cell->sampling.dropped = true;
        return true;
      }
      if (queues->data.count >= RS_QUEUE_DATA) {
        /* The oldest sample is worth least. */
        queues->data.first = (uint8_t)((queues->data.first + 1U) & (RS_QUEUE_DATA - 1U));
        queues->data.count = RS_QUEUE_DATA - 1;
        if (queues->data_again > 0U) --queues->data_again;
        ++cell->counts.frames_dropped;
        cell->sampling.dropped = true;
      }
      place = rs_ring_append(&queues->data, queues->data_frame, RS_QUEUE_DATA);
      rs_samples_sent_within(queues);
      break;
    default:
      place = rs_ring_append(&queues->slow, queues->slow_frame, RS_QUEUE_SLOW);
      if (place == NULL) place = replaceable(queues, frame);
      break;
  }
  if (place == NULL) {
    const rs_frame_type type = rs_frame_type_of(frame);
    if (type == RS_TYPE_topology || type == RS_TYPE_join) {
      ++cell->counts.repeats_dropped;
    } else {
      ++cell->counts.frames_dropped;
    }
    return false;
  }
  rs_frame_copy(place, frame);
  return true;
}

void rs_queue_down(rs_cell* cell, const uint8_t* frame) {
  rs_queues* queues = &cell->queues;
  uint8_t ports = 0;
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    const rs_neighbour* neighbour = &cell->route.neighbour[port];
    if (neighbour->child && neighbour->up && port + 1U != cell->route.parent_port) ports |= (uint8_t)(1U << port);
  }
  if (ports == 0U) return;
  uint8_t* place = rs_ring_append(&queues->down, queues->down_frame, RS_QUEUE_DOWN);
  if (place == NULL) {
    ++cell->counts.frames_dropped;
    return;
  }
  memcpy(place, frame, RS_FRAME_BYTES);
  queues->down_ports[(queues->down.first + queues->down.count - 1U) & (RS_QUEUE_DOWN - 1U)] = ports;
}

void rs_queues_turn(rs_cell* cell) {
  rs_queues* queues = &cell->queues;
  /* No port beyond the last one: a bit of such a port would never be cleared, and hold up the queue for ever. */
  const unsigned all = (1U << RS_PORTS) - 1U, others = all & ~(1U << (cell->route.parent_port & 7U) >> 1);
  for (unsigned i = 0; i < queues->down.count; ++i) {
    queues->down_ports[(queues->down.first + i) & (RS_QUEUE_DOWN - 1U)] &= (uint8_t)others;
  }
  rs_down_let_go(queues);
}

/* Whether so many cells send more than a line carries. */
static bool too_many(const rs_cell* cell, uint32_t size) {
  if (cell->settings.mode != RS_MODE_CLOCK) return false;
  const uint32_t period_us = rs_sampling_period_us(&cell->settings);
  return period_us != 0U && size * PERIOD_US > RS_LINE_CELLS * period_us;
}

void rs_queues_throttle(rs_cell* cell, uint32_t before, uint32_t size) {
  if (too_many(cell, size)) {
    if (size > before) cell->queues.data_most = RS_QUEUE_CROWDED;
  } else if (too_many(cell, before)) {
    cell->queues.data_most = RS_QUEUE_DATA; /* some were counted twice */
  }
}

void rs_queues_forget_samples(rs_cell* cell) {
  rs_queues* queues = &cell->queues;
  const uint32_t forgotten = queues->data.count;
  if (forgotten == 0U) return;
  cell->counts.frames_dropped += forgotten;
  cell->sampling.dropped = true;
  queues->data.count = queues->data_again = 0;
}

/* The samples sent last wait again: none older, and so many in all at most. */
static void repeat(rs_cell* cell, uint32_t oldest_us, unsigned most, bool again_too, uint32_t now_us) {
  rs_queues* queues = &cell->queues;
  rs_ring* ring = &queues->data;
  if (now_us - queues->data_sent_us > RS_REPEAT_MOST_US) queues->data_sent = 0;
  for (; queues->data_sent > 0U && ring->count < most; --queues->data_sent) {
    const uint8_t last = (uint8_t)((ring->first - 1U) & (RS_QUEUE_DATA - 1U));
    const uint8_t* frame = queues->data_frame[last];
    if (rs_sample_age_us(cell, frame, now_us) > oldest_us || (!again_too && rs_frame_is_retransmitted(frame))) return;
    ring->first = last;
    ++ring->count;
    ++queues->data_again;
  }
}

/* Of the samples sent lately only those stay that a rate divisor of two would leave: enough to hear of every cell, and
 * more than that would keep others waiting. */
static void thin_out_sent(rs_cell* cell, uint32_t now_us) {
  rs_queues* queues = &cell->queues;
  unsigned left = 0;
  for (unsigned i = 1; i <= queues->data_sent; ++i) {
    const uint8_t* frame = queues->data_frame[(queues->data.first - i) & (RS_QUEUE_DATA - 1U)];
    if (rs_sampling_left_out(cell, frame, now_us)) continue;
    ++left;
    if (left != i) rs_frame_copy(queues->data_frame[(queues->data.first - left) & (RS_QUEUE_DATA - 1U)], frame);
  }
  queues->data_sent = (uint8_t)left;
  if (queues->data_most >= RS_QUEUE_DATA) queues->data_most = RS_QUEUE_CALMED - REPEAT_TICKS;
}

void rs_queues_repeat_lost(rs_cell* cell, uint32_t since_us, uint32_t now_us) {
  if (cell->queues.data_sent > SENT_FEW) thin_out_sent(cell, now_us);
  const uint32_t silent_us = now_us - since_us, most_us = RS_REPEAT_MOST_US - RS_REPEAT_US;
  repeat(cell, RS_REPEAT_US + (silent_us < most_us ? silent_us : most_us), RS_QUEUE_DATA, true, now_us);
}

/* What came here as a repetition is not repeated: where many lines spoil frames, it would multiply from cell to cell.
 */
void rs_queues_repeat_lossy(rs_cell* cell, uint32_t now_us) {
  repeat(cell, RS_REPEAT_MOST_US, LOSSY_AT_ONCE, false, now_us);
}

void rs_queues_check(rs_cell* cell, uint32_t now_us) {
  rs_queues* queues = &cell->queues;
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    if (now_us - queues->started_us[port] >= RS_SENDING_US) queues->busy &= (uint8_t)~(1U << port);
  }
  if (queues->data.count > RS_QUEUE_DATA) queues->data.count = 0;
  if (queues->data_most > RS_QUEUE_CALMED || queues->data_most < RS_QUEUE_CROWDED) queues->data_most = RS_QUEUE_DATA;
  if (queues->data_sent > RS_QUEUE_DATA - queues->data.count) queues->data_sent = 0;
  if (queues->data_again > queues->data.count) queues->data_again = queues->data.count;
  if (queues->slow.count > RS_QUEUE_SLOW) queues->slow.count = 0;
  if (queues->down.count > RS_QUEUE_DOWN) queues->down.count = 0;
  rs_queues_turn(cell);
}
