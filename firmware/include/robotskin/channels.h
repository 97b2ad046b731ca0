/* SPDX-License-Identifier: Apache-2.0
 * The channels of a cell: width on the wire, and what one count means.
 *
 * Raw values are what sensors deliver and what frames carry; one count of channel c is
 * STEP_NUMERATOR / STEP_DENOMINATOR of its unit. */
#ifndef ROBOTSKIN_CHANNELS_H
#define ROBOTSKIN_CHANNELS_H

#include <stdint.h>

#include "robotskin/portable.h"

/* X(name, signed, bits, step numerator, step denominator, unit)
 * Proximity is a share of full scale; forces span 0 to 10 N; acceleration is specific force in standard gravities. */
#define RS_CHANNELS(X)                  \
  X(proximity, 0, 16, 1, 65536, "1")    \
  X(force_1, 0, 10, 10, 1024, "N")      \
  X(force_2, 0, 10, 10, 1024, "N")      \
  X(force_3, 0, 10, 10, 1024, "N")      \
  X(acceleration_x, 1, 10, 1, 256, "g") \
  X(acceleration_y, 1, 10, 1, 256, "g") \
  X(acceleration_z, 1, 10, 1, 256, "g") \
  X(temperature_1, 1, 8, 1, 2, "degC")  \
  X(temperature_2, 1, 14, 1, 32, "degC")

/* Further channels of a board, six at most of up to 16 bits each, in the form of RS_CHANNELS; and their sensors, in the
 * form of RS_SENSORS. They travel in frames of their own, `further`, about 8 times a second. A board may define both
 * lists before it includes this. */
#ifndef RS_FURTHER_CHANNELS
#define RS_FURTHER_CHANNELS(X)
#define RS_FURTHER_SENSORS(X)
#endif
#define RS_ALL_CHANNELS(X) RS_CHANNELS(X) RS_FURTHER_CHANNELS(X)

/* X(sensor, signed, first channel, channels, column, value before the first sample, unit there)
 * A sensor has some channels in a row. In the host's arrays it is a column of SI values: (N) or (N, channels). */
#define RS_SENSORS(X)                                                          \
  X(proximity, 0, proximity, 1, proximity, 0, "0 to 1")                        \
  X(force, 0, force_1, 3, normal_force, 0, "newton, >= 0")                     \
  X(acceleration, 1, acceleration_x, 3, acceleration, 0, "m/s^2, cell frame")  \
  X(temperature, 1, temperature_1, 2, temperature, unknown, "degrees Celsius") \
  RS_FURTHER_SENSORS(X)

#define RS_CHANNEL_INDEX(name, is_signed, bits, numerator, denominator, unit) RS_CHANNEL_##name,
typedef enum {
  RS_CHANNELS(RS_CHANNEL_INDEX) RS_CHANNEL_COUNT, /* of a sample frame */
  RS_CHANNEL_BEFORE_FURTHER = RS_CHANNEL_COUNT - 1,
  RS_FURTHER_CHANNELS(RS_CHANNEL_INDEX) RS_CHANNEL_ALL_COUNT
} rs_channel;
#undef RS_CHANNEL_INDEX

/* One sample of all channels, in counts. */
typedef struct {
  int32_t value[RS_CHANNEL_ALL_COUNT];
} rs_sample;

#define RS_CHANNEL_SUM(name, is_signed, bits, numerator, denominator, unit) +(bits)
enum { RS_SAMPLE_BITS = 0 RS_CHANNELS(RS_CHANNEL_SUM) };
#undef RS_CHANNEL_SUM
RS_STATIC_ASSERT(RS_SAMPLE_BITS == 98, "the nine channels take 98 bits on the wire");

enum { RS_FURTHER_CHANNELS_MAX = 6, RS_FURTHER_CHANNEL_COUNT = (int)RS_CHANNEL_ALL_COUNT - (int)RS_CHANNEL_COUNT };
RS_STATIC_ASSERT((int)RS_FURTHER_CHANNEL_COUNT <= (int)RS_FURTHER_CHANNELS_MAX,
                 "one frame carries six further channels");
#define RS_CHANNEL_FITS(name, is_signed, bits, numerator, denominator, unit) &&(bits) <= 16
RS_STATIC_ASSERT(1 RS_FURTHER_CHANNELS(RS_CHANNEL_FITS), "a further channel has 16 bits at most");
#undef RS_CHANNEL_FITS

#define RS_SENSOR_CHANNELS(name, is_signed, first, channels, column, blank, unit) +(channels)
RS_STATIC_ASSERT(0 RS_SENSORS(RS_SENSOR_CHANNELS) == (int)RS_CHANNEL_ALL_COUNT, "every channel is of one sensor");
#undef RS_SENSOR_CHANNELS

#endif
