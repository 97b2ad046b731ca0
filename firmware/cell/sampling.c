/* SPDX-License-Identifier: Apache-2.0
 * When a cell samples, and which samples it sends: all of them in clock mode; in event mode those in which a channel
 * has moved by its threshold from the value last sent [Cheng19 Algorithm 1], and one for freshness after a silence
 * or a change of route. */
#include "cell/sampling.h"

#include <string.h>

#include "cell/time/clock.h"
#include "cell/time/sample_clock.h"
#include "cell/time/spread.h"
#include "cell/torque/cell_torque.h"
#include "cell/transport/queues.h"
#include "robotskin/crc.h"

#define CHANNEL_LOW(name, is_signed, bits, numerator, denominator, unit) (is_signed) != 0 ? -(1 << ((bits) - 1)) : 0,
#define CHANNEL_HIGH(name, is_signed, bits, numerator, denominator, unit) \
  (1 << ((is_signed) != 0 ? (bits) - 1 : (bits))) - 1,
enum {
  FURTHER_EVERY = 32,      /* that many clock samples, the place of one is taken by further channels */
  FURTHER_US = 128000,     /* between two frames of them in event mode */
  SENSOR_LIMIT = 1 << 17,  /* no sensor has more than 18 bits */
  PHASES_PER_US_BITS = 20, /* 64ths of a tick, of less than one the same as by division */
  PHASES_PER_US = ((64 << PHASES_PER_US_BITS) + RS_TICK_US - 1) / RS_TICK_US
};

static const int32_t channel_low[RS_CHANNEL_ALL_COUNT] = {RS_ALL_CHANNELS(CHANNEL_LOW)};
static const int32_t channel_high[RS_CHANNEL_ALL_COUNT] = {RS_ALL_CHANNELS(CHANNEL_HIGH)};

/* Silence that a cell allows itself before it sends for freshness, other in each cell and each time. */
static uint32_t silence_us(const rs_cell* cell) {
  const uint32_t draw = rs_spread(((uint32_t)cell->id << 8) | cell->sampling.sequence);
  return RS_REFRESH_US + draw % RS_REFRESH_JITTER_US;
}

static bool changed(const rs_cell* cell, const int32_t value[RS_CHANNEL_COUNT]) {
  for (unsigned c = 0; c < RS_CHANNEL_COUNT; ++c) {
    const int32_t sent = cell->sampling.sent_value[c];
    /* Damaged memory may lie further off than a difference with a sign can tell. */
    const uint32_t distance =
        value[c] > sent ? (uint32_t)value[c] - (uint32_t)sent : (uint32_t)sent - (uint32_t)value[c];
    /* [Cheng19 eq. 6] */
    if ((cell->settings.event_mask >> c & 1U) != 0U && distance >= cell->settings.threshold[c]) return true;
  }
  return false;
}

static void send(rs_cell* cell, const int32_t value[RS_CHANNEL_COUNT], bool refresh, bool fault, uint32_t now_us) {
  rs_sampling* sampling = &cell->sampling;
  uint32_t ticks;
  const uint32_t in_tick_us = rs_left_of(now_us - cell->route.origin_us, RS_TICK_US, &ticks);
  /* [Cheng19 eq. 7] */
  const rs_clock sample = {.type = cell->settings.mode == RS_MODE_EVENT ? RS_TYPE_event : RS_TYPE_clock,
                           .source = cell->id,
                           .sequence = sampling->sequence,
                           .ttl = RS_TTL_START,
                           .sample_tick = (cell->route.wave.sequence + ticks) & 0xFU,
                           .sample_phase = in_tick_us * PHASES_PER_US >> PHASES_PER_US_BITS,
                           .refresh = refresh,
                           .fault = fault,
                           .dropped = sampling->dropped,
#define CHANNEL_VALUE(name, is_signed, bits, numerator, denominator, unit) \
  .name = CHANNEL_VALUE_##is_signed(value[RS_CHANNEL_##name]),
#define CHANNEL_VALUE_0(counts) (uint32_t)(counts)
#define CHANNEL_VALUE_1(counts) (counts)
                           RS_CHANNELS(CHANNEL_VALUE)};
  RS_WORDS uint8_t frame[RS_FRAME_BYTES];
  rs_clock_pack(frame, &sample);
  rs_frame_seal(frame);
  /* What found no room counts as not sent: the next sample tries again. */
  if (!rs_queue_up(cell, frame, now_us)) return;
  memcpy(sampling->sent_value, value, sizeof sampling->sent_value);
  sampling->sent_us = now_us;
  sampling->refresh_due = false;
  sampling->dropped = false;
  ++sampling->sequence;
}

/* Whether this sample is one of `every` that the cell takes by the time of its group. */
static bool turn_of_further(const rs_cell* cell, uint32_t every, uint32_t period_us, uint32_t now_us) {
  return RS_FURTHER_CHANNEL_COUNT > 0 && !rs_sampling_divided_away(cell, cell->id, every, period_us, now_us);
}

/* The channels behind the nine. What is lost of them is not sent again. */
static void send_further(rs_cell* cell, const rs_sample* sample, bool fault, uint32_t now_us) {
  uint32_t ticks;
  const uint32_t in_tick_us = rs_left_of(now_us - cell->route.origin_us, RS_TICK_US, &ticks);
  uint32_t value[RS_FURTHER_CHANNELS_MAX] = {0};
  for (int c = 0; c < (int)RS_FURTHER_CHANNEL_COUNT; ++c) {
    value[c] = (uint32_t)sample->value[(int)RS_CHANNEL_COUNT + c] & 0xFFFFU;
  }
  const uint32_t source = cell->id;
  const rs_further further = {.type = RS_TYPE_further,
                              .source = source,
                              .sequence = cell->sampling.sequence,
                              .ttl = RS_TTL_START,
                              .sample_tick = (cell->route.wave.sequence + ticks) & 0xFU,
                              .sample_phase = in_tick_us * PHASES_PER_US >> PHASES_PER_US_BITS,
                              .fault = fault,
                              .value_1 = value[0],
                              .value_2 = value[1],
                              .value_3 = value[2],
                              .value_4 = value[3],
                              .value_5 = value[4],
                              .value_6 = value[5]};
  RS_WORDS uint8_t frame[RS_FRAME_BYTES];
  rs_further_pack(frame, &further);
  rs_frame_seal(frame);
  (void)rs_queue_up(cell, frame, now_us);
}

void rs_sampling_take(rs_cell* cell, const rs_sample* sample, bool fault, uint32_t now_us) {
  rs_sampling* sampling = &cell->sampling;
  if (!sampling->running) return;
  const uint32_t period_us = rs_sampling_period_us(&cell->settings);
  if (period_us == 0U) { /* damaged memory; healing the settings begins anew */
    sampling->running = false;
    return;
  }
  sampling->due_us = rs_sampling_next_us(cell, period_us, true, now_us);

  rs_sample calibrated;
  int32_t* value = calibrated.value;
  for (unsigned c = 0; c < RS_CHANNEL_ALL_COUNT; ++c) {
    /* Sensors cannot exceed 18 bits; an offset cannot overflow what is clamped first. */
    int32_t counts = sample->value[c];
    if (counts < -SENSOR_LIMIT) counts = -SENSOR_LIMIT;
    if (counts > SENSOR_LIMIT - 1) counts = SENSOR_LIMIT - 1;
    if (c < RS_CHANNEL_COUNT) counts += cell->settings.offset[c];
    value[c] = counts < channel_low[c] ? channel_low[c] : counts > channel_high[c] ? channel_high[c] : counts;
  }
  rs_cell_torque_feel(cell, &calibrated, now_us);
  if (cell->settings.mode == RS_MODE_EVENT) {
    const bool event = changed(cell, value);
    const bool due = sampling->refresh_due && (int32_t)(now_us - sampling->refresh_us) >= 0;
    const bool refresh = due || now_us - sampling->sent_us + period_us >= silence_us(cell);
    if (event || refresh) send(cell, value, !event, fault, now_us);
    if (turn_of_further(cell, FURTHER_US / period_us, period_us, now_us)) {
      send_further(cell, &calibrated, fault, now_us);
    }
  } else if (!rs_sampling_divided_away(cell, cell->id, cell->route.wave.rate_divisor, period_us, now_us)) {
    const uint32_t divisor = cell->route.wave.rate_divisor;
    if (turn_of_further(cell, FURTHER_EVERY * (divisor > 1U ? divisor : 1U), period_us, now_us)) {
      send_further(cell, &calibrated, fault, now_us);
    } else {
      send(cell, value, sampling->refresh_due, fault, now_us);
    }
  }
}
