/* SPDX-License-Identifier: Apache-2.0
 * Torque sums of the ports, added up to one vector for each limb's part and epoch. It is handed to the host when as
 * many cells are in it as are expected, or, where nothing is expected yet, when every port that usually reports has
 * done so; at the latest near the end of the epoch. Cells are not expected any more when they have been missing in two
 * epochs; those that came too late are expected in the next. */
#include "section_unit/torque.h"

#include <string.h>

#include "section_unit/group_time.h"
#include "section_unit/uplink.h"

enum { EPOCH_NS = RS_EPOCH_TICKS * RS_TICK_US * 1000, END_NS = RS_TORQUE_END_US * 1000, PATIENCE_EPOCHS = 1 };

static uint16_t* expected_of(rs_section_unit* unit, const rs_torque_sum* sum) {
  return &unit->torque.expected[sum->limb & 0xFU][sum->part & 3U];
}

static bool ports_reported(const rs_section_unit* unit) {
  for (unsigned port = 0; port < unit->config.ports; ++port) {
    if (unit->torque.reports[port] > 0U && (unit->torque.epoch.reported >> port & 1U) == 0U) return false;
  }
  return true;
}

static bool is_complete(rs_section_unit* unit, const rs_torque_sum* sum) {
  const uint16_t expected = *expected_of(unit, sum);
  return expected > 0U ? sum->cells >= expected : ports_reported(unit);
}

static void hand_over(rs_section_unit* unit, unsigned at, bool last, uint64_t now_ns) {
  rs_unit_epoch* epoch = &unit->torque.epoch;
  epoch->given |= (uint64_t)1 << at;
  rs_torque torque;
  rs_torque_sum_frame(&epoch->slot[at], (uint32_t)epoch->number, last, &torque);
  uint8_t content[RS_FRAME_BYTES];
  rs_torque_pack(content, &torque);
  rs_datagrams_gather(unit, 0, content, now_ns);
  unit->hurry = true;
}

/* Hands over the sums that are complete, or at the epoch's end all. */
static void hand_over_due(rs_section_unit* unit, bool end, uint64_t now_ns) {
  rs_unit_epoch* epoch = &unit->torque.epoch;
  uint64_t due = 0;
  for (unsigned i = 0; i < epoch->used; ++i) {
    if ((epoch->given >> i & 1U) == 0U && (end || is_complete(unit, &epoch->slot[i]))) due |= (uint64_t)1 << i;
  }
  for (unsigned i = 0; i < epoch->used; ++i) {
    if ((due >> i & 1U) != 0U) hand_over(unit, i, end && due >> i == 1U, now_ns);
  }
}

/* Ends the epoch, and learns from it which cells to expect. */
static void end_epoch(rs_section_unit* unit, uint64_t now_ns) {
  rs_unit_epoch* epoch = &unit->torque.epoch;
  rs_unit_torque* torque = &unit->torque;
  if (!epoch->open) return;
  epoch->open = false;
  if (epoch->used == 0U) return;
  hand_over_due(unit, true, now_ns);
  uint16_t counted[16][4];
  memset(counted, 0, sizeof counted);
  for (unsigned i = 0; i < epoch->used; ++i) {
    counted[epoch->slot[i].limb & 0xFU][epoch->slot[i].part & 3U] = epoch->slot[i].cells;
  }
  bool complete = !epoch->late;
  for (unsigned limb = 0; limb < 16U; ++limb) {
    for (unsigned part = 0; part < 4U; ++part) {
      if (counted[limb][part] < torque->expected[limb][part]) complete = false;
    }
  }
  if (complete) {
    ++torque->complete;
    torque->missing = 0;
  } else {
    ++torque->incomplete;
    ++torque->missing;
  }
  const bool forget = complete || torque->missing > PATIENCE_EPOCHS;
  for (unsigned limb = 0; limb < 16U; ++limb) {
    for (unsigned part = 0; part < 4U; ++part) {
      uint16_t* expected = &torque->expected[limb][part];
      if (forget || counted[limb][part] > *expected) *expected = counted[limb][part];
    }
  }
}

static void begin_epoch(rs_section_unit* unit, uint64_t number, uint64_t now_ns) {
  end_epoch(unit, now_ns);
  rs_unit_epoch* epoch = &unit->torque.epoch;
  epoch->number = number;
  epoch->reported = 0;
  epoch->used = 0;
  epoch->given = 0;
  epoch->late = false;
  epoch->open = true;
  for (unsigned port = 0; port < unit->config.ports; ++port) {
    rs_arq_receiver_epoch(&unit->port[port].arq_receiver);
    if (!unit->port[port].root) unit->torque.reports[port] = 0;
    if (unit->torque.reports[port] > 0U) --unit->torque.reports[port];
  }
}

void rs_unit_torque_tick(rs_section_unit* unit, uint64_t now_ns) {
  const uint64_t number = unit->tick_time / RS_EPOCH_TICKS;
  /* One that has begun early stays. */
  if (unit->torque.epoch.number != number && unit->torque.epoch.number != number + 1U)
    begin_epoch(unit, number, now_ns);
}

void rs_unit_torque_receive(rs_section_unit* unit, unsigned port, const uint8_t* frame, uint64_t now_ns) {
  rs_torque torque;
  rs_torque_unpack(&torque, frame);
  rs_unit_port* here = &unit->port[port];
  if (!here->root || !rs_arq_receiver_first(&here->arq_receiver, torque.serial)) return;
  rs_unit_epoch* epoch = &unit->torque.epoch;
  const uint64_t early_ns = (uint64_t)RS_TORQUE_EARLY_US * 1000U;
  if (torque.epoch == ((epoch->number + 1U) & RS_EPOCH_MASK) &&
      rs_unit_time(unit, now_ns) + early_ns >= (epoch->number + 1U) * EPOCH_NS) {
    begin_epoch(unit, epoch->number + 1U, now_ns);
  }
  if (torque.last != 0U) unit->torque.reports[port] = RS_TORQUE_FAITH;
  if (torque.epoch != (epoch->number & RS_EPOCH_MASK)) {
    ++unit->torque.late;
    return;
  }
  unsigned at = 0;
  while (at < epoch->used && (epoch->slot[at].limb != torque.limb || epoch->slot[at].part != torque.part)) ++at;
  if (torque.cells > 0U && at < RS_UNIT_TORQUE_SLOTS) {
    if (at == epoch->used) rs_torque_sum_start(&epoch->slot[epoch->used++], torque.limb, torque.part);
    if (!epoch->open || (epoch->given >> at & 1U) != 0U) {
      ++unit->torque.late;
      epoch->late = true;
      epoch->slot[at].cells = (uint16_t)(epoch->slot[at].cells + torque.cells);
      if (!epoch->open && *expected_of(unit, &epoch->slot[at]) < epoch->slot[at].cells) {
        *expected_of(unit, &epoch->slot[at]) = epoch->slot[at].cells;
      }
      return;
    }
    rs_torque_sum_add(&epoch->slot[at], &torque);
  }
  if (torque.last != 0U) epoch->reported |= (uint16_t)(1U << port);
  if (epoch->open) hand_over_due(unit, false, now_ns);
}

uint64_t rs_unit_torque_end(rs_section_unit* unit, uint64_t now_ns) {
  const rs_unit_epoch* epoch = &unit->torque.epoch;
  if (!epoch->open || epoch->used == 0U) return UINT64_MAX;
  const uint64_t end_ns = epoch->number * EPOCH_NS + END_NS;
  if (rs_unit_time(unit, now_ns) < end_ns) return end_ns - unit->ahead_ns;
  end_epoch(unit, now_ns);
  return UINT64_MAX;
}
