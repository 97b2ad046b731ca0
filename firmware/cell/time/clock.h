/* SPDX-License-Identifier: Apache-2.0
 * Times on a clock that wraps. */
#ifndef ROBOTSKIN_CELL_TIME_CLOCK_H
#define ROBOTSKIN_CELL_TIME_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

#include "robotskin/portable.h"

/* Whether time a is at or after time b, on a clock that wraps. */
RS_INLINE bool rs_reached(uint32_t a, uint32_t b) {
  return (int32_t)(a - b) >= 0;
}

/* What is left of a time after whole periods, and how many they are. Of a time of a few periods, that is of any but in
 * damaged memory, a small processor finds it sooner than by a division. */
RS_INLINE uint32_t rs_left_of(uint32_t time_us, uint32_t period_us, uint32_t* periods) {
  *periods = 0;
  for (unsigned turn = 0; turn < 4U; ++turn) {
    if (time_us < period_us) return time_us;
    time_us -= period_us;
    ++*periods;
  }
  *periods += time_us / period_us;
  return time_us % period_us;
}

#endif
