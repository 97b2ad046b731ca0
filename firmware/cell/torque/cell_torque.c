/* SPDX-License-Identifier: Apache-2.0
 * The torque that touch on this cell means for the joints below it [Cheng19 section IV-B6]: parameters kept in flash,
 * force by the newest sample, posture by the newest broadcast. Without any of the three, or with one that is
 * too old, the cell adds nothing and is not among the cells of its limb's sum. */
#include "cell/torque/cell_torque.h"

#include "cell/memory/integrity.h"
#include "cell/time/sample_clock.h"
#include "cell/wire/wave.h"

enum { NO_CHECKSUM = 65536, EPOCH_MASK = (1 << RS_TICK_TIME_BITS) / RS_EPOCH_TICKS - 1 };

static uint32_t sum_of(const rs_cell_torque* own) {
  return own->known ? rs_sum_of(&own->parameters, sizeof own->parameters) : 0U;
}

static void forget(rs_cell* cell) {
  cell->cell_torque.known = false;
  cell->cell_torque.sum = 0;
  cell->torque.own.parts = 0;
}

void rs_cell_contribute(rs_cell* cell, const rs_contribution* contribution) {
  if (cell->cell_torque.known) return;
  cell->torque.own = *contribution;
  if (contribution->limb > 0xFU || contribution->parts > RS_TORQUE_PARTS) cell->torque.own.parts = 0;
  cell->cell_torque.own_sum = rs_sum_of(&cell->torque.own, sizeof cell->torque.own);
}

void rs_cell_torque_load(rs_cell* cell) {
  rs_cell_torque* own = &cell->cell_torque;
  forget(cell);
  if (!rs_torque_parameters_unpack(&own->parameters, cell->flash + RS_FLASH_TORQUE_AT)) return;
  own->known = true;
  own->sum = sum_of(own);
  cell->torque.own.limb = own->parameters.limb;
}

void rs_cell_torque_write(rs_cell* cell, const rs_command* word) {
  forget(cell);
  uint8_t* at = cell->flash + RS_FLASH_TORQUE_AT + word->index * RS_TORQUE_WORD_BYTES;
  at[0] = (uint8_t)(word->value_high >> 8);
  at[1] = (uint8_t)word->value_high;
  rs_store32(at + 2, word->value_low);
}

bool rs_cell_torque_commit(rs_cell* cell, uint32_t checksum) {
  uint8_t* image = cell->flash + RS_FLASH_TORQUE_AT;
  if (checksum != rs_torque_parameters_checksum(image)) return false;
  image[RS_TORQUE_CHECKSUM_AT] = (uint8_t)(checksum >> 8);
  image[RS_TORQUE_CHECKSUM_AT + 1] = (uint8_t)checksum;
  rs_cell_torque_load(cell);
  cell->cell_torque.felt = false; /* by other gains */
  if (cell->cell_torque.known) cell->flash_changed = true;
  return cell->cell_torque.known;
}

uint32_t rs_cell_torque_checksum(const rs_cell* cell) {
  return cell->cell_torque.known ? rs_torque_parameters_checksum(cell->flash + RS_FLASH_TORQUE_AT) : NO_CHECKSUM;
}

void rs_cell_torque_feel(rs_cell* cell, const rs_sample* calibrated, uint32_t now_us) {
  rs_cell_torque* own = &cell->cell_torque;
  if (!own->known) return;
  own->force = rs_touch_force(&own->parameters.gains, calibrated);
  own->felt_us = now_us;
  own->felt = true;
}

/* Epochs since the older of the joint positions needed; more than RS_TORQUE_AGE_MAX if they are not known. */
static uint32_t age_of(const rs_cell* cell, uint32_t parts, uint32_t epoch) {
  const rs_joints_state* joints = &cell->joints;
  uint32_t age = 0;
  for (unsigned part = 0; part < parts; ++part) {
    if (joints->limb != cell->cell_torque.parameters.limb || (joints->received_mask >> part & 1U) == 0U)
      return EPOCH_MASK;
    const uint32_t since = (epoch - joints->epoch[part]) & EPOCH_MASK;
    /* The broadcast may be ahead by one epoch. */
    if (since != EPOCH_MASK && since > age) age = since;
  }
  return age;
}

static bool compute(rs_cell* cell) {
  const rs_torque_parameters* parameters = &cell->cell_torque.parameters;
  const rs_chain* chain = &parameters->chain;
  rs_contribution* own = &cell->torque.own;
  int16_t position[RS_CHAIN_JOINTS];
  for (unsigned l = 0; l < chain->joints; ++l) {
    position[l] = cell->joints.position[l];
    /* A joint beyond its end would carry products beyond 32 bits. */
    if ((chain->prismatic >> l & 1U) != 0U) position[l] = (int16_t)rs_saturated(position[l], parameters->slide);
  }
  bool within = rs_chain_torque(chain, position, cell->cell_torque.force, own->joint);
  for (unsigned l = 0; l < chain->joints; ++l) {
    own->joint[l] = rs_shifted(rs_saturated(own->joint[l], INT32_MAX - (1 << RS_TORQUE_BITS)),
                               (unsigned)RS_TORQUE_BITS - parameters->step_bits);
    within = within && own->joint[l] <= INT16_MAX && own->joint[l] >= INT16_MIN;
  }
  return within;
}

void rs_cell_torque_update(rs_cell* cell, uint32_t epoch, uint32_t now_us) {
  rs_cell_torque* own = &cell->cell_torque;
  if (sum_of(own) != own->sum) rs_cell_torque_load(cell);
  if (!own->known) {
    /* A torque that was not asked for is worse than none. */
    if (own->own_sum != rs_sum_of(&cell->torque.own, sizeof cell->torque.own)) cell->torque.own.parts = 0;
    return;
  }
  rs_contribution* contribution = &cell->torque.own;
  const uint32_t joints = own->parameters.chain.joints;
  const uint32_t parts = (joints + RS_JOINTS_PER_PART - 1U) / RS_JOINTS_PER_PART;
  const uint32_t age = age_of(cell, parts, epoch);
  /* A sample must have been missed before its force is too old. */
  if (now_us - own->felt_us > 2U * rs_sampling_period_us(&cell->settings)) own->felt = false;
  contribution->limb = own->parameters.limb;
  contribution->parts = 0;
  if (!own->felt || !cell->sampling.running || age > RS_TORQUE_AGE_MAX) return;
  for (unsigned l = 0; l < RS_TORQUE_PARTS * RS_JOINTS_PER_PART; ++l) contribution->joint[l] = 0;
  own->force = own->force < 0 ? 0 : rs_saturated(own->force, RS_TOUCH_FORCE_LIMIT);
  contribution->active = own->force > 0;
  contribution->age = (uint8_t)age;
  if (contribution->active && !compute(cell)) ++cell->counts.torques_saturated;
  contribution->parts = (uint8_t)parts;
}
