/* SPDX-License-Identifier: Apache-2.0
 * Phases and jitters that differ from cell to cell. */
#ifndef ROBOTSKIN_CELL_TIME_SPREAD_H
#define ROBOTSKIN_CELL_TIME_SPREAD_H

#include <stdint.h>

#include "robotskin/portable.h"

/* The golden ratio's fraction with 16 bits: its multiples divide a circle more evenly than chance. */
enum { RS_GOLDEN_FRACTION = 40503 };

/* Spreads any number over 32 bits: phases and jitters that differ from cell to cell. */
RS_INLINE uint32_t rs_spread(uint32_t x) {
  x ^= x >> 16;
  x *= 0x7FEB352DU;
  x ^= x >> 15;
  x *= 0x846CA68BU;
  return x ^ (x >> 16);
}

#endif
