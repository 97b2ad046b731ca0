/* SPDX-License-Identifier: Apache-2.0
 * What time it is for the whole group, and how old a sample is by it. */
#include "cell/time/tick_time.h"

#include "cell/wire/wave.h"

static RS_NOINLINE uint32_t divided(uint32_t time) {
  return time / RS_TICK_US;
}

/* Over the length of a tick, rounded down. Small processors divide by a loop, so short times are multiplied. */
static uint32_t in_ticks(uint32_t time) {
  enum { SHORT = 64 * RS_TICK_US, BITS = 26, RECIPROCAL = ((1 << BITS) + RS_TICK_US - 1) / RS_TICK_US };
  return time < SHORT ? time * (uint32_t)RECIPROCAL >> BITS : divided(time);
}
RS_STATIC_ASSERT(RS_TICK_US == 1000, "the product fits 32 bits, and its error is less than a thousandth");

uint32_t rs_tick_time(const rs_cell* cell, uint32_t now_us) {
  const uint32_t since_ms = in_ticks(now_us - cell->route.origin_us);
  return (rs_wave_time(&cell->route.wave) + since_ms) & ((1U << RS_TICK_TIME_BITS) - 1U);
}

enum {
  CYCLE = 16 * 64, /* sample times are told modulo 16 ticks, in 64ths */
  /* The time of another tree, whose cells have just come here, may be ahead by so much. What is left of the cycle must
   * hold the oldest event that may come, which has been kept to the last and then sent on its way. */
  GUARD = CYCLE - (RS_ARQ_KEEP_US + 500) * 64 / RS_TICK_US
};

uint32_t rs_sample_age_us(const rs_cell* cell, const uint8_t* frame, uint32_t now_us) {
  uint32_t words[5];
  rs_content_load(words, frame);
  const uint32_t sampled =
      rs_bits_get(words, RS_event_sample_tick_AT, 4) * 64U + rs_bits_get(words, RS_event_sample_phase_AT, 6);
  const uint32_t since_us = now_us - cell->route.origin_us;
  const uint32_t ticks = in_ticks(since_us);
  const uint32_t now = (cell->route.wave.sequence + ticks) * 64U + in_ticks((since_us - ticks * RS_TICK_US) * 64U);
  const uint32_t age = (now - sampled + GUARD) % CYCLE;
  return age > GUARD ? (age - GUARD) * RS_TICK_US / 64U : 0U;
}
