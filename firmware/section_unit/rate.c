/* SPDX-License-Identifier: Apache-2.0
 * The rate divisor of a port. What the tree would send is its size, known within a few milliseconds of any change,
 * times the rate of its cells, which is measured; the divisor is the least that brings it below what a port carries. It
 * rises at once and falls when the load has been lower for a while. Should cells lose frames all the same, events being
 * what no divisor thins out, it rises by one and stays there, longer each time. */
#include "section_unit/rate.h"

enum {
  LINE_WINDOW_TICKS = 8,
  /* Jitter and slow clocks make frames longer; a line that is full may carry so little. */
  LINE_FULL = LINE_WINDOW_TICKS * RS_TICK_US / RS_FRAME_US * 37 / 40,
  RATE_WINDOW_TICKS = 64,
  RISE_TICKS = 3, /* sizes are right again after so many */
  FALL_TICKS = 100,
  HOLD_TICKS = 1000,
  HOLD_TICKS_MAX = 60000,
  DIVISOR_MAX = 15,
  /* Frames a line carries each second, and what it needs for ticks, status, and the unforeseen. */
  LINE_HZ = 1000000 / RS_FRAME_US,
  TICKS_HZ = 1100,
  STATUS_HZ = 1000000 / RS_STATUS_MEAN_US,
  OTHERS_HZ = 840,
  RESERVED_HZ = TICKS_HZ + STATUS_HZ + OTHERS_HZ,
  SUM_HZ = 1000000 / (RS_EPOCH_TICKS * RS_TICK_US), /* at least: one limb's torque sums */
  PORT_HZ = LINE_HZ - RESERVED_HZ /* samples and torque sums: those of 70 cells at 250 Hz, and of a limb */
};
RS_STATIC_ASSERT((int)RS_LINE_CELLS == ((int)PORT_HZ - (int)SUM_HZ) / (int)RS_CLOCK_RATE_DEFAULT_HZ,
                 "cells and section units know the same limit");

void rs_rate_start(rs_unit_rate* rate) {
  *rate = (rs_unit_rate){.divisor = 1};
  rs_rate_forget(rate);
}

void rs_rate_forget(rs_unit_rate* rate) {
  rate->rate_hz = RS_CLOCK_RATE_DEFAULT_HZ;
  rate->sums_hz = SUM_HZ;
  rate->size = 0;
}

void rs_rate_heard(rs_unit_rate* rate, const uint8_t* frame) {
  ++rate->line;
  const rs_frame_type type = rs_frame_type_of(frame);
  rate->sums += type == RS_TYPE_torque;
  if (type != RS_TYPE_clock && type != RS_TYPE_event) return;
  rate->samples += type == RS_TYPE_clock;
  if ((frame[RS_clock_dropped_AT / 8] >> (7U - RS_clock_dropped_AT % 8) & 1U) != 0U) rate->drops = rate->lossy = true;
}

static void measure(rs_unit_rate* rate, uint32_t size) {
  if (rate->size == size && size > 0U) {
    const uint32_t divisor = rate->divisor > 1U ? rate->divisor : 1U;
    const uint32_t measured_hz = rate->samples * divisor * 1000U / (RATE_WINDOW_TICKS * size);
    /* Clock rates go in steps of two. Lines lose samples, so that a fifth more than a step is the next one. */
    uint32_t known_hz = RS_CLOCK_RATE_DEFAULT_HZ;
    while (known_hz > 1U && measured_hz * 5U < known_hz * 3U) known_hz /= 2U;
    if (known_hz > rate->rate_hz || !rate->lossy) rate->rate_hz = (uint16_t)known_hz;
  }
  /* No divisor thins out torque sums, so that it does not fall while many come, even if cells move all the time. What
   * a repair costs for a moment is no reason to begin with it. */
  if ((rate->size == size && size > 0U) || rate->divisor > 1U) {
    const uint32_t sums_hz = rate->sums * 1000U / RATE_WINDOW_TICKS;
    rate->sums_hz = (uint16_t)(sums_hz < SUM_HZ ? SUM_HZ : sums_hz > PORT_HZ / 2 ? PORT_HZ / 2 : sums_hz);
  }
  rate->samples = rate->sums = 0;
  rate->lossy = false;
  rate->ticks = 0;
  rate->size = (uint16_t)size;
}

/* Cells lose frames although the divisor should do: events take the line. */
static void thin_out(rs_unit_rate* rate, uint32_t least) {
  rate->rate_hz = RS_CLOCK_RATE_DEFAULT_HZ;
  if (least > rate->divisor) return;
  rate->floor = (uint8_t)(rate->divisor < 2U ? 2 : rate->divisor < DIVISOR_MAX ? rate->divisor + 1U : DIVISOR_MAX);
  const uint32_t hold = rate->hold_next_ticks > HOLD_TICKS ? rate->hold_next_ticks : HOLD_TICKS;
  rate->hold_ticks = (uint16_t)hold;
  rate->hold_next_ticks = (uint16_t)(2U * hold > HOLD_TICKS_MAX ? HOLD_TICKS_MAX : 2U * hold);
}

/* To two at once, and to more when that has been needed for some ticks: where a large subtree looks for its way, sizes
 * count some cells twice for a moment. */
static void rise(rs_unit_rate* rate, uint32_t least) {
  rate->low_ticks = 0;
  if (rate->rise_ticks == 0U || least < rate->rise) rate->rise = (uint8_t)least;
  ++rate->rise_ticks;
  if (rate->divisor == 1U) rate->divisor = 2;
  if (rate->rise_ticks < RISE_TICKS) return;
  rate->divisor = rate->rise;
  rate->rise_ticks = 0;
}

bool rs_rate_tick(rs_unit_rate* rate, uint32_t size) {
  if (rate->size != size) rate->size = 0;
  ++rate->ticks;
  if (rate->ticks >= RATE_WINDOW_TICKS) measure(rate, size);
  const uint32_t samples_hz = PORT_HZ - rate->sums_hz;
  uint32_t least = (size * rate->rate_hz + samples_hz - 1U) / samples_hz;
  if (rate->ticks % LINE_WINDOW_TICKS == 0U) {
    const bool overflowing = rate->drops && rate->line >= LINE_FULL && size > 0U;
    if (overflowing && rate->overflowed) thin_out(rate, least);
    rate->overflowed = overflowing;
    rate->drops = false;
    rate->line = 0;
  }
  if (rate->hold_ticks > 0U && --rate->hold_ticks == 0U) rate->floor = 0;
  if (least < rate->floor) least = rate->floor;
  if (least < 1U) least = 1;
  if (least > DIVISOR_MAX) least = DIVISOR_MAX;

  const uint32_t before = rate->divisor;
  if (least <= rate->divisor) rate->rise_ticks = 0;
  if (least > rate->divisor) {
    rise(rate, least);
  } else if (least == rate->divisor) {
    rate->low_ticks = 0;
  } else if (++rate->low_ticks >= FALL_TICKS) {
    rate->divisor = (uint8_t)least;
    rate->low_ticks = 0;
  }
  /* A window with two divisors in it measures neither. */
  if (rate->divisor != before) rate->size = 0;
  return rate->divisor != before;
}
