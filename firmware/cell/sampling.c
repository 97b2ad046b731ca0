/* When a cell samples, and which samples it sends: all of them in clock mode; in event mode those in which a channel
 * has moved by its threshold from the value last sent (Cheng et al. 2019, eq. 6 and 7, Algorithm 1), and one for
 * freshness after a silence or a change of route. */
#include <string.h>

#include "cell/parts.h"

#define CHANNEL_LOW(name, is_signed, bits, numerator, denominator, unit) (is_signed) != 0 ? -(1 << ((bits) - 1)) : 0,
#define CHANNEL_HIGH(name, is_signed, bits, numerator, denominator, unit) \
  (1 << ((is_signed) != 0 ? (bits) - 1 : (bits))) - 1,
enum {
  SOURCE_MASK = (1 << (RS_clock_source_LAST - RS_clock_source_AT + 1)) - 1,
  CLOCK_ROUND_US = 65536 * RS_TICK_US, /* added so that no difference of times is negative */
  OVERDUE_US = 1000000                 /* no board is so late for a sample: its time is damaged memory */
};

static const int32_t channel_low[RS_CHANNEL_COUNT] = {RS_CHANNELS(CHANNEL_LOW)};
static const int32_t channel_high[RS_CHANNEL_COUNT] = {RS_CHANNELS(CHANNEL_HIGH)};

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
  return (((id * 40503U) & 0xFFFFU) * period_us) >> 16;
}

/* The next sample after one at `now_us` (or the first, if nothing was sampled). Periods that divide the tick numbers
 * are locked to the section unit's time, each cell at a phase of its own, so that the cells of a tree neither sample at
 * once nor drift into each other. */
static uint32_t next_sample_us(const rs_cell* cell, uint32_t period_us, bool sampled, uint32_t now_us) {
  const uint32_t period_ticks = period_us * 4195U >> 22;           /* whole ticks, up to a second, come out right */
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
  if (sampling->running) sampling->due_us = next_sample_us(cell, period_us, false, now_us);
}

void rs_sampling_check(rs_cell* cell, uint32_t now_us) {
  const rs_sampling* sampling = &cell->sampling;
  const uint32_t period_us = rs_sampling_period_us(&cell->settings);
  const bool wanted = period_us != 0U && cell->id != RS_ID_NONE && cell->route.timed;
  const bool far = sampling->due_us - now_us > 2U * period_us && now_us - sampling->due_us > OVERDUE_US;
  if ((sampling->running != 0U) != wanted || (wanted && far)) rs_sampling_restart(cell, now_us);
}

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
    if ((cell->settings.event_mask >> c & 1U) != 0U && distance >= cell->settings.threshold[c]) return true;
  }
  return false;
}

/* Whether a divisor leaves out the sample that a cell took at a time. Samples are counted by the section unit's time,
 * so that the cells of a tree, whose ids follow each other, take turns. */
static bool divided_away(const rs_cell* cell, uint32_t id, uint32_t divisor, uint32_t period_us, uint32_t at_us) {
  if (divisor < 2U) return false;
  const uint32_t time_us = cell->route.wave.sequence * RS_TICK_US + (at_us - cell->route.origin_us);
  const uint32_t number = (time_us + CLOCK_ROUND_US + period_us / 2U - phase_us(id, period_us)) / period_us;
  return (number + id) % divisor != 0U;
}

bool rs_sampling_left_out(const rs_cell* cell, const uint8_t* frame, uint32_t now_us) {
  const uint32_t divisor = cell->route.wave.rate_divisor;
  const uint32_t period_us = cell->settings.mode == RS_MODE_CLOCK ? rs_sampling_period_us(&cell->settings) : 0U;
  return divided_away(cell, rs_load32(frame) >> (31U - RS_clock_source_LAST) & SOURCE_MASK, divisor < 2U ? 2U : divisor,
                      period_us != 0U ? period_us : 1000000U / RS_CLOCK_RATE_DEFAULT_HZ,
                      now_us - rs_sample_age_us(cell, frame, now_us));
}

static void send(rs_cell* cell, const int32_t value[RS_CHANNEL_COUNT], bool refresh, bool fault, uint32_t now_us) {
  rs_sampling* sampling = &cell->sampling;
  uint32_t ticks;
  const uint32_t in_tick_us = rs_left_of(now_us - cell->route.origin_us, RS_TICK_US, &ticks);
  const rs_clock sample = {
      .type = cell->settings.mode == RS_MODE_EVENT ? RS_TYPE_event : RS_TYPE_clock,
      .source = cell->id,
      .sequence = sampling->sequence,
      .ttl = RS_TTL_START,
      .sample_tick = (cell->route.wave.sequence + ticks) & 0xFU,
      .sample_phase = in_tick_us * 67109U >> 20, /* 64ths: of less than a tick, the same as by division */
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

void rs_sampling_take(rs_cell* cell, const rs_sample* sample, bool fault, uint32_t now_us) {
  rs_sampling* sampling = &cell->sampling;
  if (!sampling->running) return;
  const uint32_t period_us = rs_sampling_period_us(&cell->settings);
  if (period_us == 0U) { /* damaged memory; whoever heals the settings begins anew */
    sampling->running = false;
    return;
  }
  sampling->due_us = next_sample_us(cell, period_us, true, now_us);

  rs_sample calibrated;
  int32_t* value = calibrated.value;
  for (unsigned c = 0; c < RS_CHANNEL_COUNT; ++c) {
    /* Sensors cannot exceed 18 bits; an offset cannot overflow what is clamped first. */
    int32_t counts = sample->value[c];
    if (counts < -131072) counts = -131072;
    if (counts > 131071) counts = 131071;
    counts += cell->settings.offset[c];
    value[c] = counts < channel_low[c] ? channel_low[c] : counts > channel_high[c] ? channel_high[c] : counts;
  }
  rs_own_torque_feel(cell, &calibrated, now_us);
  if (cell->settings.mode == RS_MODE_EVENT) {
    const bool event = changed(cell, value);
    const bool due = sampling->refresh_due && (int32_t)(now_us - sampling->refresh_us) >= 0;
    const bool refresh = due || now_us - sampling->sent_us + period_us >= silence_us(cell);
    if (event || refresh) send(cell, value, !event, fault, now_us);
  } else if (!divided_away(cell, cell->id, cell->route.wave.rate_divisor, period_us, now_us)) {
    send(cell, value, sampling->refresh_due, fault, now_us);
  }
}
