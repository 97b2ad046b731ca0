/* One epoch of a cell: it begins with the epoch's tick and ends with the report. */
#include "cell/parts.h"

static rs_torque_sum* slot_for(rs_torque_epoch* epoch, uint32_t limb, uint32_t part) {
  for (unsigned i = 0; i < epoch->used; ++i) {
    if (epoch->slot[i].limb == limb && epoch->slot[i].part == part) return &epoch->slot[i];
  }
  if (epoch->used >= RS_TORQUE_SLOTS) return 0;
  rs_torque_sum_start(&epoch->slot[epoch->used], limb, part);
  return &epoch->slot[epoch->used++];
}

static void add_own(rs_torque_epoch* epoch) {
  const rs_contribution* own = &epoch->own;
  for (unsigned part = 0; part < own->parts && part < RS_TORQUE_PARTS; ++part) {
    rs_torque_sum* sum = slot_for(epoch, own->limb, part);
    for (unsigned i = 0; i < RS_JOINTS_PER_PART; ++i) {
      const int32_t joint = own->joint[RS_JOINTS_PER_PART * part + i];
      sum->joint[i] = joint > INT16_MAX ? INT16_MAX : joint < INT16_MIN ? INT16_MIN : joint;
      sum->saturated = sum->saturated || sum->joint[i] != joint;
    }
    sum->cells = 1;
    sum->active = own->active ? 1 : 0;
    sum->age = own->age;
  }
}

static void report(rs_cell* cell, uint32_t now_us) {
  rs_torque_epoch* epoch = &cell->torque;
  epoch->open = false;
  epoch->waiting = 0;
  for (unsigned i = 0; i < epoch->used; ++i) {
    rs_torque torque;
    rs_torque_sum_frame(&epoch->slot[i], epoch->epoch, i + 1U == epoch->used, &torque);
    if (!rs_retention_torque(cell, &torque, now_us)) ++cell->counts.torques_dropped;
  }
}

static void begin(rs_cell* cell, uint32_t number, uint32_t now_us) {
  rs_torque_epoch* epoch = &cell->torque;
  if (epoch->open) report(cell, now_us);                        /* a tick must have come very late */
  const uint32_t frames = epoch->used == 0U ? 1U : epoch->used; /* that a report is likely to have again */
  const uint32_t hop_us = RS_TORQUE_HOP_US + frames * RS_TORQUE_FRAME_US;
  epoch->epoch = number;
  epoch->used = 0;
  epoch->waiting = 0;
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    const rs_neighbour* neighbour = &cell->route.neighbour[port];
    if (!neighbour->child || !neighbour->up) epoch->reports[port] = 0;
    if (epoch->reports[port] == 0U) continue;
    --epoch->reports[port];
    epoch->waiting |= (uint8_t)(1U << port);
  }
  add_own(epoch);
  epoch->open = epoch->used > 0U || epoch->waiting != 0U;
  if (!epoch->open) return;
  epoch->deadline_us = now_us + RS_TORQUE_WAIT_US + (uint32_t)cell->route.subtree_height * hop_us;
  if (epoch->deadline_us - now_us > RS_TORQUE_WAIT_MAX_US) epoch->deadline_us = now_us + RS_TORQUE_WAIT_MAX_US;
  rs_timer_set(cell, now_us);
}

void rs_torque_receive(rs_cell* cell, unsigned port, const uint8_t* frame, uint32_t now_us) {
  rs_torque_epoch* epoch = &cell->torque;
  rs_neighbour* neighbour = &cell->route.neighbour[port];
  rs_torque torque;
  rs_torque_unpack(&torque, frame);
  /* A cell that has just booted has forgotten what it had. */
  if (!neighbour->child || !neighbour->up || cell->route.in_quarantine) {
    ++cell->counts.torques_dropped;
    return;
  }
  if (!rs_hearing_first(&neighbour->hearing, torque.serial)) return;
  const bool last = torque.last != 0U;
  if (last) epoch->reports[port] = RS_TORQUE_FAITH;

  const uint32_t behind = (epoch->epoch - torque.epoch) & RS_EPOCH_MASK;
  rs_torque_sum* sum = behind == 0U && epoch->open ? slot_for(epoch, torque.limb, torque.part) : 0;
  if (sum != 0) {
    rs_torque_sum_add(sum, &torque);
  } else if (behind <= 1U || behind == RS_EPOCH_MASK) {
    torque.last = 0;
    if (!rs_retention_torque(cell, &torque, now_us)) ++cell->counts.torques_dropped;
  } else {
    ++cell->counts.torques_dropped;
  }
  if (behind == 0U && last) epoch->waiting &= (uint8_t)~(1U << port);
  if (epoch->open && epoch->waiting == 0U) report(cell, now_us);
}

void rs_torque_follow(rs_cell* cell, uint32_t now_us) {
  rs_torque_epoch* epoch = &cell->torque;
  if (cell->route.parent_port != RS_NO_PARENT) {
    const uint32_t number = rs_wave_time(&cell->route.wave) / RS_EPOCH_TICKS;
    if (number != epoch->epoch) begin(cell, number, now_us);
  }
  if (!epoch->open) return;
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    const rs_neighbour* neighbour = &cell->route.neighbour[port];
    if (!neighbour->child || !neighbour->up) epoch->waiting &= (uint8_t)~(1U << port);
  }
  const uint32_t left_us = epoch->deadline_us - now_us;
  if (epoch->waiting == 0U || left_us == 0U || left_us > RS_TORQUE_WAIT_MAX_US) report(cell, now_us);
}

void rs_cell_contribute(rs_cell* cell, const rs_contribution* contribution) {
  cell->torque.own = *contribution;
  if (contribution->limb > 0xFU || contribution->parts > RS_TORQUE_PARTS) cell->torque.own.parts = 0;
}

void rs_torque_check(rs_cell* cell) {
  if (cell->torque.used > RS_TORQUE_SLOTS) cell->torque.used = 0;
}
