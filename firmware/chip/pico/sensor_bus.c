/* SPDX-License-Identifier: Apache-2.0 */
#include "sensor_bus.h"

#include "rp2040.h"
#include "sensor_parts.h"

enum {
  I2C_CONTROL = 0x00,
  I2C_TARGET = 0x04,
  I2C_DATA = 0x10,
  I2C_HIGH = 0x1C,
  I2C_LOW = 0x20,
  I2C_INTERRUPT_MASK = 0x30,
  I2C_RAW_INTERRUPTS = 0x34,
  I2C_CLEAR = 0x40,
  I2C_CLEAR_ABORT = 0x54,
  I2C_CLEAR_STOP = 0x60,
  I2C_ENABLE = 0x6C,
  I2C_RECEIVED = 0x78,
  I2C_HOLD = 0x7C,
  I2C_SPIKES = 0xA0,
  I2C_STOPPED = 1 << 9, /* of the interrupts */
  I2C_ABORTED = 1 << 6,
  I2C_READ = 1 << 8, /* of the data */
  I2C_STOP = 1 << 9,
  I2C_RESTART = 1 << 10,
  I2C_MASTER_FAST = 1 << 6 | 1 << 5 | 2 << 1 | 1,
  SDA = 20,
  SCL = 21,

  ADC_CONTROL = 0x00,
  ADC_QUEUE = 0x08,
  ADC_VALUE = 0x0C,
  ADC_DIVIDER = 0x10,
  ADC_ON = 1 << 0,
  ADC_TEMPERATURE_ON = 1 << 1,
  ADC_GOES_ON = 1 << 3,
  ADC_INPUTS = 0x17 << 16, /* 0 to 2, and 4: the chip's temperature */
  ADC_TO_DMA = 1 << 24 | 1 << 3 | 1 << 0,
  ADC_EMPTY = 1 << 8, /* of the queue */
  ADC_DREQ = 36,
  ADC_CHANNEL = 8, /* of direct memory access */
  ADC_US = 64,     /* between two readings: 16 of each input in 4 ms */
  FORCES = 3,
  INPUTS = 4,
  READINGS = 16,
  RING_BITS = 7,
  STALE = 8 /* turns without an answer */
};

/* What a part answered last. */
typedef struct {
  uint8_t bytes[SENSOR_BYTES_MAX];
  uint8_t written; /* of the writes that start it */
  uint8_t silent;  /* turns since it answered, STALE at most */
  uint8_t turn;
} part_state;

static part_state states[SENSOR_PARTS];
static unsigned on_the_bus = SENSOR_PARTS; /* the part that is being asked, or none */
static uint16_t ring[1 << (RING_BITS - 1)] __attribute__((aligned(1 << RING_BITS)));

static void ask(unsigned part) {
  const sensor_part* asked = &sensor_parts[part];
  const part_state* state = &states[part];
  REG(I2C0 + I2C_ENABLE) = 0;
  REG(I2C0 + I2C_TARGET) = asked->address;
  REG(I2C0 + I2C_ENABLE) = 1;
  if (state->written < asked->writes) {
    REG(I2C0 + I2C_DATA) = asked->write[state->written][0];
    REG(I2C0 + I2C_DATA) = (uint32_t)asked->write[state->written][1] | I2C_STOP;
    return;
  }
  REG(I2C0 + I2C_DATA) = asked->first;
  for (unsigned at = 0; at < asked->bytes; ++at) {
    REG(I2C0 + I2C_DATA) =
        (uint32_t)I2C_READ | (at == 0U ? I2C_RESTART : 0U) | (at + 1U == asked->bytes ? I2C_STOP : 0U);
  }
}

/* The next part of this round whose turn it is. */
static void go_on(unsigned part) {
  for (; part < (unsigned)SENSOR_PARTS; ++part) {
    part_state* state = &states[part];
    if (state->silent < STALE) ++state->silent;
    if (state->turn != 0U) {
      --state->turn;
      if (state->silent > 1U) --state->silent; /* it was not asked */
      continue;
    }
    on_the_bus = part;
    ask(part);
    return;
  }
  on_the_bus = SENSOR_PARTS;
}

void sensor_bus_interrupt(void) {
  const uint32_t happened = REG(I2C0 + I2C_RAW_INTERRUPTS);
  (void)REG(I2C0 + I2C_CLEAR_STOP);
  (void)REG(I2C0 + I2C_CLEAR_ABORT);
  if (on_the_bus == (unsigned)SENSOR_PARTS || (happened & I2C_STOPPED) == 0U) return;
  const unsigned part = on_the_bus;
  part_state* state = &states[part];
  const sensor_part* asked = &sensor_parts[part];
  if ((happened & I2C_ABORTED) != 0U) {
    state->written = 0; /* it may have lost its power: it is started anew */
  } else if (state->written < asked->writes) {
    ++state->written;
  } else if (REG(I2C0 + I2C_RECEIVED) == asked->bytes) {
    for (unsigned at = 0; at < asked->bytes; ++at) state->bytes[at] = (uint8_t)REG(I2C0 + I2C_DATA);
    state->silent = 0;
    state->turn = (uint8_t)(asked->every - 1U);
  }
  go_on(part + 1U);
}

static bool read_analogue(rs_sample* sample) {
  uint32_t sum[INPUTS] = {0};
  for (unsigned at = 0; at < (unsigned)(READINGS * INPUTS); ++at) sum[at % INPUTS] += ring[at];
  bool at_end = false;
  for (unsigned force = 0; force < (unsigned)FORCES; ++force) {
    sample->value[RS_CHANNEL_force_1 + force] = force_counts(sum[force]);
    at_end |= sample->value[RS_CHANNEL_force_1 + force] == 1023;
  }
  sample->value[RS_CHANNEL_temperature_1] = chip_temperature_counts(sum[INPUTS - 1]);
  return at_end;
}

static void start_inputs(void) {
  REG(ADC + ADC_CONTROL) = ADC_ON | ADC_TEMPERATURE_ON;
  REG(ADC + ADC_QUEUE) = ADC_TO_DMA;
  REG(ADC + ADC_DIVIDER) = (48U * ADC_US - 1U) << 8;
  while ((REG(ADC + ADC_QUEUE) & ADC_EMPTY) == 0U) (void)REG(ADC + ADC_VALUE);
  const uint32_t channel = DMA + DMA_CHANNEL * ADC_CHANNEL;
  REG(channel + DMA_READ) = ADC + ADC_VALUE;
  REG(channel + DMA_WRITE) = (uint32_t)(uintptr_t)ring;
  REG(channel + DMA_COUNT) = 1U << 30; /* 19 hours; then it is started anew */
  REG(channel + DMA_CONTROL_TRIGGER) =
      (uint32_t)ADC_DREQ << 15 | ADC_CHANNEL << 11 | 1U << 10 | RING_BITS << 6 | 1U << 5 | 1U << 2 | 1U;
  REG(ADC + ADC_CONTROL) = (uint32_t)ADC_INPUTS | ADC_GOES_ON | ADC_TEMPERATURE_ON | ADC_ON;
}

bool sensor_bus_read(rs_sample* sample) {
  if ((REG(DMA + DMA_CHANNEL * ADC_CHANNEL + DMA_CONTROL) & DMA_BUSY) == 0U) start_inputs();
  bool fault = read_analogue(sample);
  for (unsigned part = 0; part < (unsigned)SENSOR_PARTS; ++part) {
    fault |= sensor_parts[part].take(states[part].bytes, sample);
    fault |= states[part].silent >= STALE;
  }
  if (on_the_bus == (unsigned)SENSOR_PARTS) {
    go_on(0);
  } else if (states[on_the_bus].silent < STALE) {
    ++states[on_the_bus].silent; /* it holds the bus: the others grow stale with it */
  } else {
    on_the_bus = SENSOR_PARTS; /* given up: the bus is enabled anew for the next part */
  }
  return fault;
}

static void start_bus(void) {
  for (unsigned pin = SDA; pin <= (unsigned)SCL; ++pin) {
    REG(PADS + 4 + 4 * pin) = PAD_INPUT_PULLED_UP;
    REG(IO_BANK0 + 8 * pin + 4) = PIN_I2C;
  }
  REG(I2C0 + I2C_ENABLE) = 0;
  REG(I2C0 + I2C_CONTROL) = I2C_MASTER_FAST;
  REG(I2C0 + I2C_HIGH) = 128; /* 400 kHz of 128 MHz */
  REG(I2C0 + I2C_LOW) = 192;
  REG(I2C0 + I2C_SPIKES) = 12;
  REG(I2C0 + I2C_HOLD) = 39;
  REG(I2C0 + I2C_INTERRUPT_MASK) = I2C_STOPPED;
  (void)REG(I2C0 + I2C_CLEAR);
  for (unsigned part = 0; part < (unsigned)SENSOR_PARTS; ++part) states[part].silent = STALE;
}

void sensor_bus_start(void) {
  for (unsigned pin = 26; pin < 26U + FORCES; ++pin) REG(PADS + 4 + 4 * pin) = 1U << 7; /* neither input nor output */
  start_bus();
  start_inputs();
}
