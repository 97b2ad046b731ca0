/* SPDX-License-Identifier: Apache-2.0
 * Whether memory still says what was written: uid, id and keys, settings, torque parameters. What is damaged is taken
 * from its copy or from flash, or the cell boots. */
#include "cell/memory/integrity.h"

#include "cell/time/sample_clock.h"

enum { SUM_START = 0x5EA1 }; /* any but 0: memory that is all zeros is damaged */

static RS_NOINLINE uint32_t identity_checksum(const rs_cell* cell) {
  uint32_t sum = cell->uid ^ ((uint32_t)cell->id << 8) ^ cell->keyed ^ SUM_START;
  for (unsigned i = 0; i < sizeof cell->key.word / sizeof cell->key.word[0]; ++i) {
    sum = ((sum << 5) | (sum >> 27)) ^ cell->key.word[i];
  }
  for (unsigned i = 0; i < sizeof cell->keys; i += 4U) sum = ((sum << 5) | (sum >> 27)) ^ rs_load32(cell->keys + i);
  for (unsigned i = 0; i < RS_CELL_KEY_BYTES; i += 4U) {
    sum = ((sum << 5) | (sum >> 27)) ^ rs_load32(cell->turn_key + i);
  }
  sum = ((sum << 5) | (sum >> 27)) ^ cell->turn ^ ((uint32_t)cell->step_us << 16);
  return sum;
}

typedef uint16_t RS_ALIAS halfword;

uint32_t rs_sum_of(const void* halfwords, uint32_t count) {
  const halfword* half = halfwords;
  uint32_t sum = SUM_START;
  for (uint32_t i = 0; i < count / 2U; ++i) sum = ((sum << 5) | (sum >> 27)) + half[i];
  return sum == 0U ? 1U : sum;
}

RS_STATIC_ASSERT(sizeof(rs_settings) % 2 == 0 && sizeof(rs_contribution) % 2 == 0 &&
                     sizeof(rs_torque_parameters) % 2 == 0 && _Alignof(rs_torque_parameters) == 2,
                 "what has a sum are whole halfwords");

void rs_cell_keep_settings(rs_cell* cell) {
  cell->settings_copy = cell->settings;
  cell->settings_sum = cell->settings_copy_sum = rs_sum_of(&cell->settings, sizeof cell->settings);
}

void rs_cell_heal_settings(rs_cell* cell, uint32_t now_us) {
  if (cell->led_rgb != ~cell->led_complement) {
    cell->led_rgb = 0;
    cell->led_complement = ~cell->led_rgb;
    cell->led_changed = true;
  }
  const bool whole = cell->settings_sum == rs_sum_of(&cell->settings, sizeof cell->settings);
  if (whole && cell->settings_copy_sum == cell->settings_sum) return;
  if (!whole) {
    if (cell->settings_copy_sum == rs_sum_of(&cell->settings_copy, sizeof cell->settings_copy)) {
      cell->settings = cell->settings_copy;
    } else {
      rs_settings_load(&cell->settings, cell->flash);
    }
    rs_sampling_restart(cell, now_us);
  }
  rs_cell_keep_settings(cell);
}

void rs_cell_seal(rs_cell* cell) {
  cell->identity_checksum = identity_checksum(cell);
}

bool rs_cell_sealed(const rs_cell* cell) {
  return cell->identity_checksum == identity_checksum(cell);
}
