/* SPDX-License-Identifier: Apache-2.0 */
#include "kept_images.h"

#include "flash.h"
#include "robotskin/cell.h"

enum { SLOT_BYTES = 512, SLOTS = FLASH_SECTOR_BYTES / SLOT_BYTES, SECTORS = 2, NO_SLOT = -1 };

typedef struct {
  uint8_t image[RS_FLASH_BYTES];
  uint8_t none[SLOT_BYTES - RS_FLASH_BYTES - 4];
  uint32_t number; /* greater at each image; all ones: empty */
} slot;
RS_STATIC_ASSERT(sizeof(slot) == SLOT_BYTES, "two pages of the flash");
extern const slot rs_kept_start[SECTORS * SLOTS];

static uint32_t number_of(int at) {
  return *(const volatile uint32_t*)&rs_kept_start[at].number; /* it changes beneath the compiler */
}

static int newest_slot(void) {
  int found = NO_SLOT;
  for (int at = 0; at < SECTORS * SLOTS; ++at) {
    if (number_of(at) != UINT32_MAX && (found == NO_SLOT || number_of(at) > number_of(found))) found = at;
  }
  return found;
}

const uint8_t* kept_image(void) {
  const int newest = newest_slot();
  if (newest == NO_SLOT) return 0;
  const int other = (1 - newest / SLOTS) * SLOTS;
  for (int at = other; at < other + SLOTS; ++at) {
    if (number_of(at) == UINT32_MAX) continue;
    erase_sector(&rs_kept_start[other]);
    break;
  }
  return rs_kept_start[newest].image;
}

void keep_image(const uint8_t* image) {
  static RS_WORDS slot written;
  const int newest = newest_slot();
  const int next = newest == NO_SLOT ? 0 : (newest + 1) % (SECTORS * SLOTS);
  for (unsigned i = 0; i < (unsigned)RS_FLASH_BYTES; ++i) written.image[i] = image[i];
  for (unsigned i = 0; i < sizeof written.none; ++i) written.none[i] = 0xFF;
  written.number = newest == NO_SLOT ? 0U : number_of(newest) + 1U;
  /* Only after nine images or more without a start: the cell is silent for some 45 ms. */
  if (number_of(next) != UINT32_MAX) erase_sector(&rs_kept_start[next / SLOTS * SLOTS]);
  write_flash(&rs_kept_start[next], &written, SLOT_BYTES);
}
