/* SPDX-License-Identifier: Apache-2.0 */
#include "flash.h"

enum { FLASH_AT = 0x10000000 };

/* The mask ROM's functions; the flash cannot be read while they work, and nothing here is there. */
typedef void* (*rom_lookup)(const uint16_t* table, uint32_t code);
static void* rom(char a, char b) {
  const uint16_t* halves = (const uint16_t*)0x14;
  __asm__("" : "+r"(halves));
  return ((rom_lookup)(uintptr_t)halves[2])((const uint16_t*)(uintptr_t)halves[0], (uint32_t)a | (uint32_t)b << 8);
}

static void begin(void) {
  ((void (*)(void))rom('I', 'F'))();
  ((void (*)(void))rom('E', 'X'))();
}

static void end(void) {
  ((void (*)(void))rom('F', 'C'))();
  ((void (*)(void))rom('C', 'X'))();
}

static uint32_t offset_of(const void* at) {
  return (uint32_t)(uintptr_t)at - (uint32_t)FLASH_AT;
}

void erase_sector(const void* at) {
  begin();
  ((void (*)(uint32_t, uint32_t, uint32_t, uint32_t))rom('R', 'E'))(offset_of(at), FLASH_SECTOR_BYTES,
                                                                    FLASH_SECTOR_BYTES, 0x20);
  end();
}

void write_flash(const void* at, const void* pages, uint32_t count) {
  begin();
  ((void (*)(uint32_t, const uint8_t*, uint32_t))rom('R', 'P'))(offset_of(at), pages, count);
  end();
}
