/* SPDX-License-Identifier: Apache-2.0
 * What a root fixes in its ticks. */
#ifndef ROBOTSKIN_CELL_WIRE_WAVE_H
#define ROBOTSKIN_CELL_WIRE_WAVE_H

#include <stddef.h>

#include "robotskin/cell.h"

/* Tick times go round. From RS_TICK_TIME_HALF on, `to` is from before `from`. */
enum { RS_TICK_TIME_BITS = 26, RS_TICK_TIME_HALF = 1 << (RS_TICK_TIME_BITS - 1) };
RS_INLINE uint32_t rs_ticks_between(uint32_t from, uint32_t to) {
  return (to - from) & ((1U << RS_TICK_TIME_BITS) - 1U);
}
RS_INLINE uint32_t rs_wave_time(const rs_wave* wave) {
  return ((uint32_t)wave->era << 16) | wave->sequence;
}
RS_INLINE void rs_wave_of_tick(rs_wave* wave, const rs_tick* tick) {
  *wave = (rs_wave){.tag = tick->tag,
                    .sequence = (uint16_t)tick->sequence,
                    .era = (uint16_t)tick->era,
                    .root = (uint8_t)tick->root,
                    .forming = (uint8_t)tick->forming,
                    .depth_cap = (uint8_t)tick->depth_cap,
                    .rate_divisor = (uint8_t)tick->rate_divisor,
                    .gain_threshold = (uint8_t)tick->gain_threshold};
}
RS_INLINE bool rs_waves_equal(const rs_wave* a, const rs_wave* b) {
#if defined(RS_FRAMES_AT_WORDS)
  uint32_t first[4], second[4]; /* little-endian; of the last one, the bytes that have no name do not count */
  RS_STATIC_ASSERT(sizeof first == sizeof *a && offsetof(rs_wave, none) == 13, "a wave is four words");
  __builtin_memcpy(first, a, sizeof first);
  __builtin_memcpy(second, b, sizeof second);
  return first[0] == second[0] && first[1] == second[1] && first[2] == second[2] &&
         ((first[3] ^ second[3]) & 0xFFU) == 0U;
#else
  return a->tag == b->tag && a->sequence == b->sequence && a->era == b->era && a->root == b->root &&
         a->forming == b->forming && a->depth_cap == b->depth_cap && a->rate_divisor == b->rate_divisor &&
         a->gain_threshold == b->gain_threshold;
#endif
}

#endif
