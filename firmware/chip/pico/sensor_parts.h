/* SPDX-License-Identifier: Apache-2.0
 * Sensors behind an I2C bus: a part is a row of numbers and the function that turns its bytes into channels. */
#ifndef ROBOTSKIN_SENSOR_PARTS_H
#define ROBOTSKIN_SENSOR_PARTS_H

#include <stdbool.h>
#include <stdint.h>

#include "robotskin/channels.h"
#include "robotskin/portable.h"

enum { SENSOR_WRITES_MAX = 4, SENSOR_BYTES_MAX = 6 };

typedef struct {
  uint8_t address;                                       /* on the bus, 7 bits */
  uint8_t writes;                                        /* of registers, by which it is started */
  uint8_t write[SENSOR_WRITES_MAX][2];                   /* register, value */
  uint8_t first;                                         /* register from which a reading is read, */
  uint8_t bytes;                                         /* and how many bytes it has */
  uint8_t every;                                         /* samples between two readings */
  bool (*take)(const uint8_t* bytes, rs_sample* sample); /* true: at the end of its range */
} sensor_part;

enum { SENSOR_PARTS = 3 };
extern const sensor_part sensor_parts[SENSOR_PARTS];

/* Force of a resistor that a push makes conduct, and the chip's own temperature, from sums of 16 readings of 12 bits.
 */
int32_t force_counts(uint32_t sum);
int32_t chip_temperature_counts(uint32_t sum);

#endif
