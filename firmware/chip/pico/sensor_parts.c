/* SPDX-License-Identifier: Apache-2.0
 * The parts of a cell on a breadboard. Another part is another row. */
#include "sensor_parts.h"

static int32_t signed_16(uint8_t high, uint8_t low) {
  return (int16_t)((uint32_t)high << 8 | low);
}

static bool clamp(int32_t* value, int32_t least, int32_t most) {
  const int32_t asked = *value;
  *value = asked < least ? least : asked > most ? most : asked;
  return asked <= least || asked >= most;
}

/* VCNL4010: 16 bits of reflected infrared light, the high byte first. */
static bool take_proximity(const uint8_t* bytes, rs_sample* sample) {
  sample->value[RS_CHANNEL_proximity] = (int32_t)((uint32_t)bytes[0] << 8 | bytes[1]);
  return sample->value[RS_CHANNEL_proximity] == 0xFFFF;
}

/* LIS3DH at +-2 g: 16000 is 1 g, the low byte first. A count is 1/256 g: 131 / 8192 of it. */
static bool take_acceleration(const uint8_t* bytes, rs_sample* sample) {
  bool at_end = false;
  for (unsigned axis = 0; axis < 3U; ++axis) {
    int32_t* value = &sample->value[RS_CHANNEL_acceleration_x + axis];
    *value = (signed_16(bytes[2U * axis + 1U], bytes[2U * axis]) * 131 + 4096) >> 13;
    at_end |= clamp(value, -512, 511);
  }
  return at_end;
}

/* TMP102: sixteenths of a degree in the upper 12 bits. A count is 1/32. */
static bool take_temperature(const uint8_t* bytes, rs_sample* sample) {
  sample->value[RS_CHANNEL_temperature_2] = (signed_16(bytes[0], bytes[1]) >> 4) * 2;
  return false;
}

const sensor_part sensor_parts[SENSOR_PARTS] = {
    {.address = 0x13, /* VCNL4010: 250 measurements a second, 200 mA of light, free-running */
     .writes = 3,
     .write = {{0x82, 7}, {0x83, 20}, {0x80, 3}},
     .first = 0x87,
     .bytes = 2,
     .every = 1,
     .take = take_proximity},
    {.address = 0x18, /* LIS3DH: 400 measurements a second on three axes; whole readings */
     .writes = 2,
     .write = {{0x20, 0x77}, {0x23, 0x80}},
     .first = 0x28 | 0x80,
     .bytes = 6,
     .every = 1,
     .take = take_acceleration},
    {.address = 0x48, /* TMP102 measures by itself, 4 times a second */
     .writes = 0,
     .first = 0x00,
     .bytes = 2,
     .every = 16,
     .take = take_temperature},
};

/* The resistor lies between 3.3 V and the input, 10 kohm between input and ground. It conducts about 0.07 mS for each
 * newton (FSR 402, typical; parts differ by a quarter), so force is 1.43 N x / (1 - x) for a reading of x. */
#ifndef RS_FORCE_COUNTS
#define RS_FORCE_COUNTS 146 /* 102.4 counts a newton */
#endif
int32_t force_counts(uint32_t sum) {
  const uint32_t most = 16U * 4096U;
  if (sum + 16U >= most) return 1023;
  const uint32_t counts = (uint32_t)RS_FORCE_COUNTS * sum / (most - sum);
  return counts > 1023U ? 1023 : (int32_t)counts;
}

/* 27 - (V - 0.706) / 0.001721 degrees, V of 3.3 for 4096. A count is half a degree. */
int32_t chip_temperature_counts(uint32_t sum) {
  int32_t counts = (57308611 - (int32_t)(sum * 3835U)) >> 16;
  (void)clamp(&counts, -128, 127);
  return counts;
}
