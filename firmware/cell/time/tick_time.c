/* SPDX-License-Identifier: Apache-2.0
 * What time it is for the whole group, and how old a sample is by it. */
#include "cell/time/tick_time.h"

#include "cell/wire/wave.h"

uint32_t rs_tick_time(const rs_cell* cell, uint32_t now_us) {
  const uint32_t since_ms = (now_us - cell->route.origin_us) / RS_TICK_US;
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
  const uint32_t now =
      (cell->route.wave.sequence + since_us / RS_TICK_US) * 64U + since_us % RS_TICK_US * 64U / RS_TICK_US;
  const uint32_t age = (now - sampled + GUARD) % CYCLE;
  return age > GUARD ? (age - GUARD) * RS_TICK_US / 64U : 0U;
}
