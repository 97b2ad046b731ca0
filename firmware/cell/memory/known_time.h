/* SPDX-License-Identifier: Apache-2.0
 * The time of the last adopted tick, kept with its complement: what it says is used only while the two agree. */
#ifndef ROBOTSKIN_CELL_MEMORY_KNOWN_TIME_H
#define ROBOTSKIN_CELL_MEMORY_KNOWN_TIME_H

#include "cell/wire/wave.h"

/* So many ticks the time of a cell may go back, by the sequence numbers in flight: where it was alone, it may follow
 * ticks that are played again. */
enum { RS_TIME_BACK_MOST = 0x8000 };

/* Whether a time that is so many ticks from another one (rs_ticks_between) is before it, by no more than that. */
RS_INLINE bool rs_time_went_back(uint32_t ticks) {
  return ticks > (1U << RS_TICK_TIME_BITS) - RS_TIME_BACK_MOST;
}

RS_INLINE bool rs_time_known(const rs_route* route) {
  return route->known_time == ~route->known_time_complement;
}

RS_INLINE void rs_time_learn(rs_route* route, uint32_t time) {
  route->known_time = time;
  route->known_time_complement = ~time;
}

/* Ticks from the known time to a wave. */
RS_INLINE uint32_t rs_time_ahead(const rs_route* route, const rs_wave* wave) {
  return rs_ticks_between(route->known_time, rs_wave_time(wave));
}

#endif
