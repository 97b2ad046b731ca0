/* SPDX-License-Identifier: Apache-2.0
 * What a cell is told to do, and keeps in its flash when told to store it. */
#ifndef ROBOTSKIN_SETTINGS_H
#define ROBOTSKIN_SETTINGS_H

#include <stdbool.h>
#include <stdint.h>

#include "robotskin/channels.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum { RS_MODE_CLOCK = 0, RS_MODE_EVENT = 1 } rs_mode;

enum {
  RS_CLOCK_RATE_DEFAULT_HZ = 250,
  RS_EVENT_RATE_DEFAULT_HZ = 1000,
  RS_EVENT_RATE_MIN_HZ = 8, /* a slower cell could not stay fresh */
  RS_EVENT_RATE_MAX_HZ = 1000,
  RS_EVENT_MASK_ALL = (1 << RS_CHANNEL_COUNT) - 1
};

/* X(rate in samples per second as commanded, period in microseconds): the rates a cell accepts in clock mode. */
#define RS_CLOCK_RATES(X) X(0, 0) X(63, 16000) X(125, 8000) X(250, 4000)

/* X(channel, threshold in counts): the published second standard set (0.0001, 0.005, 0.04 g, 1 degC, 0.5 degC). */
#define RS_THRESHOLDS(X) \
  X(proximity, 7)        \
  X(force_1, 5)          \
  X(force_2, 5)          \
  X(force_3, 5)          \
  X(acceleration_x, 10)  \
  X(acceleration_y, 10)  \
  X(acceleration_z, 10)  \
  X(temperature_1, 2)    \
  X(temperature_2, 16)

typedef struct {
  uint16_t id; /* 0: none kept */
  uint8_t mode;
  uint8_t clock_rate_hz;
  uint16_t event_rate_hz;
  uint16_t event_mask;
  uint16_t threshold[RS_CHANNEL_COUNT]; /* counts */
  int16_t offset[RS_CHANNEL_COUNT];     /* counts, added to each reading */
} rs_settings;

/* The image in flash: what rs_settings_store writes and rs_settings_load checks. */
enum { RS_SETTINGS_BYTES = 64 };

void rs_settings_default(rs_settings* settings);

/* Reads an image; false, and the defaults, if it is missing (NULL), damaged or of another version. */
bool rs_settings_load(rs_settings* settings, const uint8_t image[RS_SETTINGS_BYTES]);

void rs_settings_store(const rs_settings* settings, uint8_t image[RS_SETTINGS_BYTES]);

#ifdef __cplusplus
}
#endif

#endif
