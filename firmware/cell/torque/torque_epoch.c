/* SPDX-License-Identifier: Apache-2.0
 * One epoch of a cell: it begins at a time that all cells agree on, and ends with the report. */
#include "cell/torque/torque_epoch.h"

#include "cell/time/clock.h"
#include "cell/time/timer.h"
#include "cell/torque/cell_torque.h"
#include "cell/transport/arq_sender.h"
#include "cell/wire/ports.h"
#include "cell/wire/wave.h"

enum {
  EPOCH_US = RS_EPOCH_TICKS * RS_TICK_US,
  NUMBER_MASK = (1 << RS_TICK_TIME_BITS) / RS_EPOCH_TICKS - 1,
  BACK = 8 /* clocks are corrected: an epoch so little before the last one is over, others are a new time */
};

static unsigned slot_for(rs_torque_epoch* epoch, uint32_t limb, uint32_t part) {
  unsigned at = 0;
  while (at < epoch->used && (epoch->slot[at].limb != limb || epoch->slot[at].part != part)) ++at;
  if (at == epoch->used && at < RS_TORQUE_SLOTS) {
    rs_torque_sum_start(&epoch->slot[at], limb, part);
    epoch->from[at] = epoch->before[at] = 0;
    epoch->expected[at] = RS_ALL_PORTS; /* any child that is waited for may have more of it */
    ++epoch->used;
  }
  return at;
}

static void add_own(rs_cell* cell, uint32_t now_us) {
  rs_torque_epoch* epoch = &cell->torque;
  const rs_contribution* own = &epoch->own;
  for (unsigned part = 0; part < own->parts && part < RS_TORQUE_PARTS; ++part) {
    rs_torque_sum sum;
    rs_torque_sum_start(&sum, own->limb, part);
    for (unsigned i = 0; i < RS_JOINTS_PER_PART; ++i) {
      const int32_t joint = own->joint[RS_JOINTS_PER_PART * part + i];
      sum.joint[i] = joint > INT16_MAX ? INT16_MAX : joint < INT16_MIN ? INT16_MIN : joint;
      sum.saturated = sum.saturated || sum.joint[i] != joint;
    }
    sum.cells = 1;
    sum.active = own->active ? 1 : 0;
    sum.age = own->age;
    const unsigned at = slot_for(epoch, own->limb, part);
    if (at < RS_TORQUE_SLOTS) {
      epoch->slot[at] = sum;
      epoch->filled |= (uint8_t)(1U << at);
    } else {
      rs_torque torque;
      rs_torque_sum_frame(&sum, epoch->epoch, false, &torque);
      if (!rs_arq_sender_torque(cell, &torque, now_us)) ++cell->counts.torques_dropped;
    }
  }
}

static void send(rs_cell* cell, unsigned at, bool last, uint32_t now_us) {
  rs_torque_epoch* epoch = &cell->torque;
  rs_torque_sum* sum = &epoch->slot[at];
  rs_torque torque;
  rs_torque_sum_frame(sum, epoch->epoch, last, &torque);
  if (!rs_arq_sender_torque(cell, &torque, now_us)) ++cell->counts.torques_dropped;
  rs_torque_sum_start(sum, torque.limb, torque.part);
  epoch->filled &= (uint8_t)~(1U << at);
}

/* Sends every sum that waits for no child any more; with none waited for at all the report is complete. */
static void report(rs_cell* cell, uint32_t now_us) {
  rs_torque_epoch* epoch = &cell->torque;
  const bool complete = epoch->waiting == 0U;
  for (unsigned i = 0; i < epoch->used; ++i) {
    if ((epoch->filled >> i & 1U) == 0U || (epoch->expected[i] & ~epoch->from[i] & epoch->waiting) != 0U) continue;
    const bool last = complete && epoch->filled >> i == 1U;
    send(cell, i, last, now_us);
    if (last) epoch->open = false;
  }
  if (!complete || !epoch->open) return;
  /* All has been sent before it was known to be all: an empty sum says so. */
  epoch->open = false;
  if (epoch->used > 0U) send(cell, 0, true, now_us);
}

/* Keeps the slots that had anything in the last two epochs. */
static void clear_slots(rs_torque_epoch* epoch) {
  unsigned kept = 0;
  for (unsigned i = 0; i < epoch->used; ++i) {
    const uint8_t from = epoch->from[i], before = epoch->before[i];
    if ((from | before) == 0U) continue;
    rs_torque_sum_start(&epoch->slot[kept], epoch->slot[i].limb, epoch->slot[i].part);
    epoch->from[kept] = 0;
    epoch->before[kept] = from;
    epoch->expected[kept] = from | before;
    ++kept;
  }
  epoch->used = (uint8_t)kept;
  epoch->filled = 0;
}

/* While trees form, no parent knows which children to wait for, and each sum would go all the way up alone: more of
 * them than a processor bears. So none begins, and the first one waits for every child. */
static void begin_formed(rs_cell* cell, uint32_t number) {
  rs_torque_epoch* epoch = &cell->torque;
  epoch->epoch = number;
  epoch->waiting = 0;
  epoch->open = false;
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    const rs_neighbour* neighbour = &cell->route.neighbour[port];
    epoch->reports[port] = neighbour->child && neighbour->up ? RS_TORQUE_FAITH : 0;
  }
  clear_slots(epoch);
}

static void begin(rs_cell* cell, uint32_t number, uint32_t begin_us, uint32_t now_us) {
  rs_torque_epoch* epoch = &cell->torque;
  if (epoch->open) { /* the section unit's time must have leapt */
    epoch->waiting = 0;
    report(cell, now_us);
  }
  if (cell->route.wave.forming != 0U) {
    begin_formed(cell, number);
    return;
  }
  const uint32_t frames = epoch->used == 0U ? 1U : epoch->used; /* that a report is likely to have again */
  epoch->epoch = number;
  epoch->waiting = 0;
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    rs_neighbour* neighbour = &cell->route.neighbour[port];
    rs_arq_receiver_epoch(&neighbour->arq_receiver);
    if (!neighbour->child || !neighbour->up) epoch->reports[port] = 0;
    if (epoch->reports[port] > RS_TORQUE_FAITH) epoch->reports[port] = RS_TORQUE_FAITH; /* damaged memory */
    if (epoch->reports[port] == 0U) continue;
    --epoch->reports[port];
    epoch->waiting |= (uint8_t)(1U << port);
  }
  clear_slots(epoch);
  rs_cell_torque_update(cell, number, now_us);
  add_own(cell, now_us);
  epoch->open = epoch->used > 0U || epoch->waiting != 0U;
  if (!epoch->open) return;
  /* On any way up the second bound grows by what a hop takes, so that a parent never gives up before its child. */
  const uint32_t below_us =
      RS_TORQUE_WAIT_US + (uint32_t)cell->route.subtree_height * (RS_TORQUE_HOP_US + frames * RS_TORQUE_FRAME_US);
  const uint32_t above_us = (uint32_t)cell->route.hops * RS_TORQUE_WAY_US;
  const uint32_t rest_us = above_us < RS_TORQUE_WAIT_MAX_US ? RS_TORQUE_WAIT_MAX_US - above_us : 0U;
  epoch->deadline_us = begin_us + (below_us < rest_us ? below_us : rest_us);
  report(cell, now_us);
  rs_timer_set(cell, now_us);
}

/* Begins the epoch that it is, unless that has been, and tells when the next one begins. */
static void keep_time(rs_cell* cell, uint32_t now_us) {
  rs_torque_epoch* epoch = &cell->torque;
  const rs_route* route = &cell->route;
  const uint32_t tick_time = rs_wave_time(&route->wave);
  uint32_t number = tick_time / RS_EPOCH_TICKS;
  uint32_t since_us = tick_time % RS_EPOCH_TICKS * RS_TICK_US + (now_us - route->origin_us);
  if (since_us >= 2U * RS_STALE_LIMIT_US) return; /* the route is lost in a moment */
  for (; since_us >= EPOCH_US; since_us -= EPOCH_US) ++number;
  number &= NUMBER_MASK;
  const bool was_due = cell->timer_us == epoch->begin_us;
  epoch->origin_us = route->origin_us;
  epoch->begin_us = now_us + EPOCH_US - since_us;
  /* The correction may put off what was due at this very moment, or bring forward what was to come after the timer,
   * which has been set without it. */
  const bool adds = epoch->own.parts > 0U || epoch->used > 0U;
  if (was_due || (adds && rs_reached(cell->timer_us, epoch->begin_us))) cell->timer_us = epoch->begin_us;
  const uint32_t behind = (epoch->epoch - number) & NUMBER_MASK;
  if (behind >= BACK) begin(cell, number, now_us - since_us, now_us);
}

void rs_torque_receive(rs_cell* cell, unsigned port, const uint8_t* frame, uint32_t late_us, uint32_t now_us) {
  rs_torque_epoch* epoch = &cell->torque;
  rs_neighbour* neighbour = &cell->route.neighbour[port];
  rs_torque torque;
  rs_torque_unpack(&torque, frame);
  /* A cell that has just booted has forgotten what it had. */
  if (!neighbour->child || !neighbour->up || cell->route.in_quarantine) {
    ++cell->counts.torques_dropped;
    return;
  }
  if (!rs_arq_receiver_first(&neighbour->arq_receiver, torque.serial)) return;
  const bool last = torque.last != 0U;
  if (last) epoch->reports[port] = RS_TORQUE_FAITH;

  uint32_t behind = (epoch->epoch - torque.epoch) & RS_EPOCH_MASK;
  /* Its begin may be over, if the report was there first when the processor was free again. */
  if (behind == RS_EPOCH_MASK && cell->route.parent_port != RS_NO_PARENT &&
      (int32_t)(epoch->begin_us - now_us) < RS_TORQUE_EARLY_US) {
    const uint32_t begin_us = epoch->begin_us;
    epoch->begin_us += EPOCH_US;
    begin(cell, (epoch->epoch + 1U) & NUMBER_MASK, begin_us, now_us);
    behind = 0;
  }
  const unsigned at = behind == 0U && epoch->open ? slot_for(epoch, torque.limb, torque.part) : RS_TORQUE_SLOTS;
  if (at < RS_TORQUE_SLOTS) {
    rs_torque_sum_add(&epoch->slot[at], &torque);
    epoch->from[at] |= (uint8_t)(1U << port);
    if (torque.cells > 0U) epoch->filled |= (uint8_t)(1U << at);
  } else if (torque.cells == 0U) {
    /* it only said that there is no more */
  } else if (behind == RS_EPOCH_MASK || (behind <= 1U && late_us < RS_ARQ_LATE_US)) {
    torque.last = 0;
    if (!rs_arq_sender_torque(cell, &torque, now_us)) ++cell->counts.torques_dropped;
  } else {
    /* Passed on alone, what the processor had no time for makes all cells above it late in turn, for ever. */
    ++cell->counts.torques_dropped;
  }
  if (behind == 0U && last) epoch->waiting &= (uint8_t)~(1U << port);
  if (epoch->open) report(cell, now_us);
}

void rs_torque_advance(rs_cell* cell, uint32_t late_us, uint32_t now_us) {
  rs_torque_epoch* epoch = &cell->torque;
  if (cell->route.parent_port != RS_NO_PARENT &&
      (cell->route.origin_us != epoch->origin_us || rs_reached(now_us, epoch->begin_us))) {
    keep_time(cell, now_us);
  }
  if (!epoch->open) return;
  uint8_t waiting = epoch->waiting;
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    const rs_neighbour* neighbour = &cell->route.neighbour[port];
    if (!neighbour->child || !neighbour->up) waiting &= (uint8_t)~(1U << port);
  }
  /* What came before the deadline may still wait behind the input at hand. */
  const int32_t left_us = (int32_t)(epoch->deadline_us - now_us);
  if (left_us + (int32_t)late_us <= 0 || left_us > RS_TORQUE_WAIT_MAX_US) waiting = 0;
  if (waiting == epoch->waiting) return;
  epoch->waiting = waiting;
  report(cell, now_us);
}

void rs_torque_check(rs_cell* cell) {
  if (cell->torque.used > RS_TORQUE_SLOTS) cell->torque.used = 0;
}
