/* SPDX-License-Identifier: Apache-2.0 */
#include "kept_images.h"

#include "robotskin/cell.h"

enum { SLOT_BYTES = 512, SLOTS = 8, SECTORS = 2, SECTOR_BYTES = 4096, FLASH_AT = 0x10000000, NO_SLOT = -1 };

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

/* The mask ROM's functions; the flash cannot be read while they work, and nothing here is there. */
typedef void* (*rom_lookup)(const uint16_t* table, uint32_t code);
static void* rom(char a, char b) {
  const uint16_t* halves = (const uint16_t*)0x14;
  __asm__("" : "+r"(halves));
  return ((rom_lookup)(uintptr_t)halves[2])((const uint16_t*)(uintptr_t)halves[0], (uint32_t)a | (uint32_t)b << 8);
}

/* Erases a sector, or writes a slot if there is one. */
static void change_flash(int at, const slot* written) {
  const uint32_t offset = (uint32_t)(uintptr_t)&rs_kept_start[at] - (uint32_t)FLASH_AT;
  ((void (*)(void))rom('I', 'F'))();
  ((void (*)(void))rom('E', 'X'))();
  if (written == 0) {
    ((void (*)(uint32_t, uint32_t, uint32_t, uint32_t))rom('R', 'E'))(offset, SECTOR_BYTES, SECTOR_BYTES, 0x20);
  } else {
    ((void (*)(uint32_t, const uint8_t*, uint32_t))rom('R', 'P'))(offset, (const uint8_t*)written, SLOT_BYTES);
  }
  ((void (*)(void))rom('F', 'C'))();
  ((void (*)(void))rom('C', 'X'))();
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
    change_flash(other, 0);
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
  if (number_of(next) != UINT32_MAX) change_flash(next / SLOTS * SLOTS, 0);
  change_flash(next, &written);
}
