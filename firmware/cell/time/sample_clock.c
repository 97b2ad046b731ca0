/* SPDX-License-Identifier: Apache-2.0
 * When a cell samples, and which of its samples a rate divisor leaves out. */
#include "cell/time/sample_clock.h"

#include "cell/time/clock.h"
#include "cell/time/spread.h"
#include "cell/time/tick_time.h"

enum {
  SOURCE_MASK = (1 << (RS_clock_source_LAST - RS_clock_source_AT + 1)) - 1,
  CLOCK_ROUND_US = 65536 * RS_TICK_US, /* added so that no difference of times is negative */
  TICKS_PER_US_BITS =
      22, /* a division by the length of a tick, rounded up: whole ticks come out right up to a second */
  TICKS_PER_US = ((1 << TICKS_PER_US_BITS) + RS_TICK_US - 1) / RS_TICK_US,
  OVERDUE_US = 1000000 /* no board is so late for a sample: its time is damaged memory */
};

uint32_t rs_sampling_period_us(const rs_settings* settings) {
  if (settings->mode == RS_MODE_EVENT) {
    return settings->event_rate_hz == 0U ? 0U : 1000000U / settings->event_rate_hz;
  }
#define RATE_CASE(rate_hz, period_us) \
  case rate_hz:                       \
    return period_us;
  switch (settings->clock_rate_hz) {
    RS_CLOCK_RATES(RATE_CASE)
    default:
      return 0;
  }
#undef RATE_CASE
}

/* Where in the period a cell samples. Multiples of the golden ratio divide a circle more evenly than chance, whichever
 * stretch of consecutive ids a tree has (Knuth 6.4, three-distance theorem). */
static uint32_t phase_us(uint32_t id, uint32_t period_us) {
  return (((id * (uint32_t)RS_GOLDEN_FRACTION) & 0xFFFFU) * period_us) >> 16;
}

/* The next sample after one at `now_us` (or the first, if nothing was sampled). Periods that divide the tick numbers
 * are locked to the section unit's time, each cell at a phase of its own, so that the cells of a tree neither sample at
 * once nor drift into each other. */
uint32_t rs_sampling_next_us(const rs_cell* cell, uint32_t period_us, bool sampled, uint32_t now_us) {
  const uint32_t period_ticks = period_us * TICKS_PER_US >> TICKS_PER_US_BITS;
  const bool divides = (period_ticks & (period_ticks - 1U)) == 0U; /* 65536, the number of tick numbers */
  if (period_ticks * RS_TICK_US != period_us || !divides) return now_us + period_us;
  const uint32_t in_period_us = (cell->route.wave.sequence & (period_ticks - 1U)) * RS_TICK_US;
  uint32_t periods;
  const uint32_t position_us = rs_left_of(in_period_us + (now_us - cell->route.origin_us), period_us, &periods);
  uint32_t wait_us = rs_left_of(phase_us(cell->id, period_us) + period_us - position_us, period_us, &periods);
  if (wait_us == 0U || (sampled && wait_us < period_us / 2U)) wait_us += period_us;
  return now_us + wait_us;
}

void rs_sampling_refresh(rs_cell* cell, uint32_t now_us) {
  cell->sampling.refresh_due = true;
  cell->sampling.refresh_us = now_us + rs_spread(cell->id) % RS_REFRESH_SPREAD_US;
}

void rs_sampling_restart(rs_cell* cell, uint32_t now_us) {
  rs_sampling* sampling = &cell->sampling;
  const uint32_t period_us = rs_sampling_period_us(&cell->settings);
  sampling->running = period_us != 0U && cell->id != RS_ID_NONE && cell->route.timed;
  rs_sampling_refresh(cell, now_us);
  if (sampling->running) sampling->due_us = rs_sampling_next_us(cell, period_us, false, now_us);
}

void rs_sampling_check(rs_cell* cell, uint32_t now_us) {
  const rs_sampling* sampling = &cell->sampling;
  const uint32_t period_us = rs_sampling_period_us(&cell->settings);
  const bool wanted = period_us != 0U && cell->id != RS_ID_NONE && cell->route.timed;
  const bool far = sampling->due_us - now_us > 2U * period_us && now_us - sampling->due_us > OVERDUE_US;
  if ((sampling->running != 0U) != wanted || (wanted && far)) rs_sampling_restart(cell, now_us);
}

/* Whether a divisor leaves out the sample that a cell took at a time. Samples are counted by the section unit's time,
 * so that the cells of a tree, whose ids follow each other, take turns. */
bool rs_sampling_divided_away(const rs_cell* cell, uint32_t id, uint32_t divisor, uint32_t period_us, uint32_t at_us) {
  if (divisor < 2U) return false;
  const uint32_t time_us = cell->route.wave.sequence * RS_TICK_US + (at_us - cell->route.origin_us);
  const uint32_t number = (time_us + CLOCK_ROUND_US + period_us / 2U - phase_us(id, period_us)) / period_us;
  return (number + id) % divisor != 0U;
}

bool rs_sampling_left_out(const rs_cell* cell, const uint8_t* frame, uint32_t now_us) {
  const uint32_t divisor = cell->route.wave.rate_divisor;
  const uint32_t period_us = cell->settings.mode == RS_MODE_CLOCK ? rs_sampling_period_us(&cell->settings) : 0U;
  return rs_sampling_divided_away(cell, rs_load32(frame) >> (31U - RS_clock_source_LAST) & SOURCE_MASK,
                                  divisor < 2U ? 2U : divisor,
                                  period_us != 0U ? period_us : 1000000U / RS_CLOCK_RATE_DEFAULT_HZ,
                                  now_us - rs_sample_age_us(cell, frame, now_us));
}
