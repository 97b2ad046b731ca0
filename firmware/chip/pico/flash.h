/* SPDX-License-Identifier: Apache-2.0
 * Changes of the flash, which cannot be read meanwhile. */
#ifndef ROBOTSKIN_FLASH_H
#define ROBOTSKIN_FLASH_H

#include <stdint.h>

enum { FLASH_SECTOR_BYTES = 4096 };

/* Sets all bits of the sector at an address; takes some 45 ms. */
void erase_sector(const void* at);

/* Writes whole pages of 256 bytes where all bits are set. */
void write_flash(const void* at, const void* pages, uint32_t count);

#endif
