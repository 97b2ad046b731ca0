/* SPDX-License-Identifier: Apache-2.0
 * The time of the last adopted tick, kept with its complement: what it says is used only while the two agree. */
#ifndef ROBOTSKIN_CELL_MEMORY_KNOWN_TIME_H
#define ROBOTSKIN_CELL_MEMORY_KNOWN_TIME_H

#include "cell/wire/wave.h"

RS_INLINE bool rs_time_known(const rs_route* route) {
  return route->known_time == ~route->known_time_complement;
}

RS_INLINE void rs_time_learn(rs_route* route, uint32_t time) {
  route->known_time = time;
  route->known_time_complement = ~time;
}

/* Ticks from the known time to a wave; from RS_TICK_TIME_HALF on, the wave is from before. */
enum { RS_TICK_TIME_HALF = 1U << (RS_TICK_TIME_BITS - 1) };
RS_INLINE uint32_t rs_time_ahead(const rs_route* route, const rs_wave* wave) {
  return (rs_wave_time(wave) - route->known_time) & ((1U << RS_TICK_TIME_BITS) - 1U);
}

#endif
