/* SPDX-License-Identifier: Apache-2.0
 * The settings as they come from the maker, and their image in flash. */
#include "robotskin/settings.h"

#include <stddef.h>

#include "robotskin/crc.h"

/* Image: version (1 byte), id 2, mode 1, clock rate 1, event rate 2, event mask 2, thresholds 9 x 2, offsets 9 x 2,
 * zeros, checksum 2; numbers big-endian. An erased flash (all ones) fails the checksum or the version. */
enum { IMAGE_VERSION = 1, IMAGE_CHECKED_BYTES = RS_SETTINGS_BYTES - 2 };

static uint8_t* put16(uint8_t* at, uint32_t value) {
  at[0] = (uint8_t)(value >> 8);
  at[1] = (uint8_t)value;
  return at + 2;
}

static const uint8_t* get16(const uint8_t* at, uint16_t* value) {
  *value = (uint16_t)(((uint32_t)at[0] << 8) | at[1]);
  return at + 2;
}

void rs_settings_default(rs_settings* settings) {
#define THRESHOLD(channel, counts) counts,
  static const uint16_t threshold[RS_CHANNEL_COUNT] = {RS_THRESHOLDS(THRESHOLD)};
#undef THRESHOLD
  *settings = (rs_settings){.mode = RS_MODE_CLOCK,
                            .clock_rate_hz = RS_CLOCK_RATE_DEFAULT_HZ,
                            .event_rate_hz = RS_EVENT_RATE_DEFAULT_HZ,
                            .event_mask = RS_EVENT_MASK_ALL};
  for (unsigned c = 0; c < RS_CHANNEL_COUNT; ++c) settings->threshold[c] = threshold[c];
}

bool rs_settings_load(rs_settings* settings, const uint8_t image[RS_SETTINGS_BYTES]) {
  rs_settings_default(settings);
  if (image == NULL || image[0] != IMAGE_VERSION) return false;
  const uint16_t crc = rs_crc16(image, IMAGE_CHECKED_BYTES);
  if (image[IMAGE_CHECKED_BYTES] != (uint8_t)(crc >> 8) || image[IMAGE_CHECKED_BYTES + 1] != (uint8_t)crc) return false;
  const uint8_t* at = get16(image + 1, &settings->id);
  settings->mode = *at++;
  settings->clock_rate_hz = *at++;
  at = get16(at, &settings->event_rate_hz);
  at = get16(at, &settings->event_mask);
  for (unsigned c = 0; c < RS_CHANNEL_COUNT; ++c) at = get16(at, &settings->threshold[c]);
  for (unsigned c = 0; c < RS_CHANNEL_COUNT; ++c) {
    uint16_t bits;
    at = get16(at, &bits);
    settings->offset[c] = (int16_t)((int32_t)(bits ^ 0x8000U) - 0x8000);
  }
  return true;
}

void rs_settings_store(const rs_settings* settings, uint8_t image[RS_SETTINGS_BYTES]) {
  for (unsigned i = 0; i < RS_SETTINGS_BYTES; ++i) image[i] = 0;
  image[0] = IMAGE_VERSION;
  uint8_t* at = put16(image + 1, settings->id);
  *at++ = settings->mode;
  *at++ = settings->clock_rate_hz;
  at = put16(at, settings->event_rate_hz);
  at = put16(at, settings->event_mask);
  for (unsigned c = 0; c < RS_CHANNEL_COUNT; ++c) at = put16(at, settings->threshold[c]);
  for (unsigned c = 0; c < RS_CHANNEL_COUNT; ++c) at = put16(at, (uint16_t)settings->offset[c]);
  put16(image + IMAGE_CHECKED_BYTES, rs_crc16(image, IMAGE_CHECKED_BYTES));
}
