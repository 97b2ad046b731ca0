/* Torque sums of the ports, added up to one vector for each limb and epoch. An epoch is handed to the host when every
 * port that usually reports has done so and no cell is missing that is expected, or else at its end. Cells are not
 * expected any more when they have been missing in two epochs. */
#include <string.h>

#include "section_unit/unit_parts.h"

enum { EPOCH_NS = RS_EPOCH_TICKS * RS_TICK_US * 1000, END_NS = RS_TORQUE_END_US * 1000, PATIENCE_EPOCHS = 1 };

static rs_unit_epoch* epoch_of(rs_section_unit* unit, uint64_t number) {
  return &unit->torque.epoch[number & 1U];
}

static void hand_over(rs_section_unit* unit, rs_unit_epoch* epoch, bool complete, uint64_t now_ns) {
  epoch->open = false;
  if (epoch->used == 0U) return;
  if (complete) {
    ++unit->torque.complete;
    unit->torque.missing = 0;
  } else {
    ++unit->torque.incomplete;
    ++unit->torque.missing;
  }
  const bool learn = complete || unit->torque.missing > PATIENCE_EPOCHS;
  if (learn) memset(unit->torque.expected, 0, sizeof unit->torque.expected);
  for (unsigned i = 0; i < epoch->used; ++i) {
    const rs_torque_sum* sum = &epoch->slot[i];
    if (learn) unit->torque.expected[sum->limb & 0xFU][sum->part & 3U] = sum->cells;
    rs_torque torque;
    rs_torque_sum_frame(sum, (uint32_t)epoch->number, i + 1U == epoch->used, &torque);
    uint8_t content[RS_FRAME_BYTES];
    rs_torque_pack(content, &torque);
    rs_datagrams_gather(unit, 0, content, now_ns);
  }
  unit->hurry = true;
}

static bool is_complete(const rs_section_unit* unit, const rs_unit_epoch* epoch) {
  if (epoch->used == 0U) return false;
  for (unsigned port = 0; port < unit->config.ports; ++port) {
    if (unit->torque.reports[port] > 0U && (epoch->reported >> port & 1U) == 0U) return false;
  }
  uint16_t missing[16][4];
  memcpy(missing, unit->torque.expected, sizeof missing);
  for (unsigned i = 0; i < epoch->used; ++i) {
    const rs_torque_sum* sum = &epoch->slot[i];
    if (sum->cells >= missing[sum->limb & 0xFU][sum->part & 3U]) missing[sum->limb & 0xFU][sum->part & 3U] = 0;
  }
  for (unsigned limb = 0; limb < 16U; ++limb) {
    for (unsigned part = 0; part < 4U; ++part) {
      if (missing[limb][part] != 0U) return false;
    }
  }
  return true;
}

void rs_unit_torque_tick(rs_section_unit* unit, uint64_t now_ns) {
  const uint64_t number = unit->tick_time / RS_EPOCH_TICKS;
  rs_unit_epoch* epoch = epoch_of(unit, number);
  if (epoch->number == number) return;
  for (unsigned i = 0; i < 2U; ++i) {
    if (unit->torque.epoch[i].open) hand_over(unit, &unit->torque.epoch[i], false, now_ns);
  }
  epoch->number = number;
  epoch->reported = 0;
  epoch->used = 0;
  epoch->open = true;
  for (unsigned port = 0; port < unit->config.ports; ++port) {
    if (!unit->port[port].root) unit->torque.reports[port] = 0;
    if (unit->torque.reports[port] > 0U) --unit->torque.reports[port];
  }
}

void rs_unit_torque_receive(rs_section_unit* unit, unsigned port, const uint8_t* frame, uint64_t now_ns) {
  rs_torque torque;
  rs_torque_unpack(&torque, frame);
  rs_unit_port* here = &unit->port[port];
  if (!here->root || !rs_hearing_first(&here->hearing, torque.serial)) return;
  if (torque.last != 0U) unit->torque.reports[port] = RS_TORQUE_FAITH;
  rs_unit_epoch* epoch = epoch_of(unit, unit->tick_time / RS_EPOCH_TICKS);
  if (!epoch->open || (epoch->number & RS_EPOCH_MASK) != torque.epoch) {
    ++unit->torque.late;
    if ((epoch->number & RS_EPOCH_MASK) == torque.epoch) {
      unit->torque.expected[torque.limb][torque.part] += (uint16_t)torque.cells; /* the next epoch waits for it */
    }
    return;
  }
  rs_torque_sum* sum = epoch->slot;
  unsigned at = 0;
  while (at < epoch->used && (sum[at].limb != torque.limb || sum[at].part != torque.part)) ++at;
  if (at == epoch->used) {
    if (at == RS_UNIT_TORQUE_SLOTS) return;
    rs_torque_sum_start(&sum[epoch->used++], torque.limb, torque.part);
  }
  rs_torque_sum_add(&sum[at], &torque);
  if (torque.last != 0U) epoch->reported |= (uint16_t)(1U << port);
  if (is_complete(unit, epoch)) hand_over(unit, epoch, true, now_ns);
}

uint64_t rs_unit_torque_end(rs_section_unit* unit, uint64_t now_ns) {
  rs_unit_epoch* epoch = epoch_of(unit, unit->tick_time / RS_EPOCH_TICKS);
  if (!epoch->open || epoch->used == 0U) return UINT64_MAX;
  const uint64_t end_ns = epoch->number * EPOCH_NS + END_NS;
  if (rs_unit_time(unit, now_ns) < end_ns) return end_ns - unit->ahead_ns;
  hand_over(unit, epoch, false, now_ns);
  return UINT64_MAX;
}
