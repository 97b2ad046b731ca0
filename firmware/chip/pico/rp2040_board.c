/* SPDX-License-Identifier: Apache-2.0
 * The board of a Raspberry Pi Pico. It runs at 128 MHz, a whole multiple of the lines' rate, with all code in RAM. */
#include "board.h"
#include "pico/kept_images.h"
#include "pico/kept_keys.h"
#include "pico/rp2040.h"
#include "pico/sensor_bus.h"
#include "pico/serial_lines.h"

enum {
  LIGHT_AT = 16,  /* pins: red, green, blue */
  FORGET_AT = 22, /* pin: at ground when the board is switched on, it forgets its keys */
  STEP_US = 38,   /* 4834 cycles of the emulated chip for a tick that four beacons answer, at 128 MHz */
  TIMER_ALARM0 = 0x10,
  TIMER_INTR = 0x34,
  TIMER_INTE = 0x38,
  INTERRUPTS = 1 << IRQ_TIMER0 | 1 << IRQ_PIO0 | 1 << IRQ_PIO1 | 1 << IRQ_DMA0 | 1 << IRQ_I2C0
};

extern const uint32_t rs_made_start; /* the serial number: its own page of the flash */

/* What the program asked and was answered, for a comparison with the same program elsewhere. */
#ifdef RS_RECORD
#define RECORD(word) (REG(RS_RECORD) = (uint32_t)(word))
#else
#define RECORD(word) ((void)(word))
#endif

static uint32_t wanted, wake_us[2], armed;

void rs_interrupt(void) {
  uint32_t number;
  __asm__ volatile("mrs %0, ipsr" : "=r"(number));
  number -= 16U;
  if (number == IRQ_TIMER0) {
    REG(TIMER + TIMER_INTR) = 1;
  } else if (number == IRQ_I2C0) {
    sensor_bus_interrupt();
  } else {
    serial_lines_interrupt(number);
  }
}

/* ---- Start ---- */

static void take_out_of_reset(uint32_t which) {
  REG(RESETS + SET) = which;
  REG(RESETS + CLR) = which;
  while ((REG(RESETS + 8) & which) != which) {
  }
}

/* 12 MHz times `feedback`, divided by both. */
static void start_pll(uint32_t pll, uint32_t reset, uint32_t feedback, uint32_t first, uint32_t second) {
  take_out_of_reset(reset);
  REG(pll + 0x00) = 1;
  REG(pll + 0x08) = feedback;
  REG(pll + CLR + 0x04) = 1U << 0 | 1U << 5;
  while ((REG(pll) >> 31) == 0U) {
  }
  REG(pll + 0x0C) = first << 16 | second << 12;
  REG(pll + CLR + 0x04) = 1U << 3;
}

static void start_clocks(void) {
  REG(XOSC + 0x00) = 0xAA0;
  REG(XOSC + 0x0C) = 47;
  REG(XOSC + SET) = 0xFABU << 12;
  while ((REG(XOSC + 0x04) >> 31) == 0U) {
  }
  REG(CLOCKS + 0x30) = 2; /* reference: crystal */
  while (REG(CLOCKS + 0x38) != 4U) {
  }
  start_pll(PLL_SYS, RESET_PLL_SYS, 128, 6, 2); /* 128 MHz */
  start_pll(PLL_USB, RESET_PLL_USB, 100, 5, 5); /* 48 MHz, for the analogue inputs */
  REG(CLOCKS + 0x3C) = 0U << 5 | 1U;            /* system: PLL */
  while (REG(CLOCKS + 0x44) != 2U) {
  }
  REG(CLOCKS + 0x60) = 1U << 11 | 0U << 5; /* analogue inputs: the other PLL */
  REG(WATCHDOG + 0x2C) = 1U << 9 | 12U;    /* a microsecond */
}

static void start_light(void) {
  for (unsigned colour = 0; colour < 3U; ++colour) REG(IO_BANK0 + 8U * (LIGHT_AT + colour) + 4U) = PIN_PWM;
  for (unsigned slice = 0; slice < 2U; ++slice) {
    REG(PWM + 0x14 * slice + 0x10) = 254; /* full is on all the time */
    REG(PWM + 0x14 * slice + 0x00) = 1;
  }
}

/* From bits of the ring oscillator, which no two moments have alike. */
static uint32_t random_word(void) {
  uint32_t word = REG(TIMER + TIMER_RAW);
  for (unsigned bit = 0; bit < 64U; ++bit) word = (word << 1 | word >> 31) ^ (REG(ROSC + 0x1C) & 1U);
  return word;
}

static void show(uint32_t rgb) {
  REG(PWM + 0x0C) = (rgb >> 16 & 0xFFU) | (rgb >> 8 & 0xFFU) << 16;
  REG(PWM + 0x14 + 0x0C) = rgb & 0xFFU;
}

/* Whether the pin that says so is at ground, all the time. */
static bool shall_forget(void) {
  enum { LOOKS = 100, GPIO_IN = 0xD0000004 };
  REG(PADS + 4 + 4 * FORGET_AT) = PAD_INPUT_PULLED_UP;
  for (uint32_t look = 0, at = REG(TIMER + TIMER_RAW); look < LOOKS; at = REG(TIMER + TIMER_RAW), ++look) {
    while (REG(TIMER + TIMER_RAW) == at) {
    }
    if (look > 0U && (REG(GPIO_IN) >> FORGET_AT & 1U) != 0U) return false;
  }
  return true;
}

/* Its keys, once it has some. */
static const uint8_t* await_keys(void) {
  if (shall_forget()) forget_keys();
  if (kept_keys() != 0) return kept_keys();
  show(0x404040); /* white: it waits for them */
  take_keys(rs_made_start);
  show(0);
  return kept_keys();
}

void rs_board_start(rs_boot* boot) {
  REG(0xE000ED08) = 0x20000000; /* vectors are in RAM */
  start_clocks();
  take_out_of_reset(RESET_ADC | RESET_DMA | RESET_I2C0 | RESET_IO | RESET_PADS | RESET_PIO0 | RESET_PIO1 | RESET_PWM |
                    RESET_TIMER);
  boot->flash = kept_image();
  serial_lines_start();
  start_light();
  sensor_bus_start();
  REG(TIMER + TIMER_INTE) = 1;
  REG(0xE000E280) = 0xFFFFFFFF;
  REG(0xE000E100) = INTERRUPTS;
  boot->uid = rs_made_start;
  boot->keys = await_keys();
  boot->random = random_word();
  boot->step_us = STEP_US;
  RECORD(12);
  RECORD(boot->random);
  RECORD(boot->step_us);
}

/* ---- Time and events ---- */

uint32_t rs_board_now_us(void) {
  const uint32_t now_us = REG(TIMER + TIMER_RAW);
  RECORD(1);
  RECORD(now_us);
  return now_us;
}

void rs_board_wanted(uint32_t ports) {
  RECORD(2);
  RECORD(ports);
  wanted = ports;
}

void rs_board_alarms(uint32_t timer_us, bool sampling, uint32_t sample_us, uint32_t ports) {
  RECORD(3);
  RECORD(timer_us);
  RECORD(sampling);
  RECORD(sampling ? sample_us : 0U);
  RECORD(ports);
  wake_us[0] = timer_us;
  wake_us[1] = sample_us;
  armed = RS_BOARD_TIMER | (sampling ? RS_BOARD_SAMPLE : 0);
  wanted = ports;
}

/* What has happened and is not waited for any more from now on. */
static uint32_t take_events(void) {
  uint32_t events = serial_lines_come() * RS_BOARD_LINE | (serial_lines_gone() & wanted) * RS_BOARD_SENT;
  const uint32_t now_us = REG(TIMER + TIMER_RAW);
  for (unsigned i = 0; i < 2U; ++i) {
    const uint32_t event = (uint32_t)RS_BOARD_TIMER << i;
    if ((armed & event) != 0U && (int32_t)(now_us - wake_us[i]) >= 0) events |= event;
  }
  armed &= ~events;
  return events;
}

/* The alarm rings when the clock is equal to it, so one whose time has come meanwhile never would: false. */
static bool set_alarm(void) {
  const uint32_t now_us = REG(TIMER + TIMER_RAW);
  uint32_t wait_us = 1000000;
  for (unsigned i = 0; i < 2U; ++i) {
    if ((armed & (uint32_t)RS_BOARD_TIMER << i) != 0U && wake_us[i] - now_us < wait_us) wait_us = wake_us[i] - now_us;
  }
  REG(TIMER + TIMER_ALARM0) = now_us + wait_us;
  return (int32_t)(REG(TIMER + TIMER_RAW) - (now_us + wait_us)) < 0;
}

uint32_t rs_board_wait(void) {
  for (;;) {
    __asm__ volatile("cpsid i" ::: "memory"); /* an interrupt that comes from here on ends the sleep */
    const uint32_t events = take_events();
    if (events == 0U && set_alarm()) __asm__ volatile("wfi" ::: "memory");
    __asm__ volatile("cpsie i" ::: "memory");
    if (events == 0U) continue;
    RECORD(4);
    RECORD(events);
    return events;
  }
}

/* ---- Lines ---- */

uint32_t rs_board_receive(unsigned port, const uint8_t** bytes, bool* idle) {
  const uint32_t count = serial_lines_receive(port, bytes, idle);
  RECORD(5);
  RECORD(count | (uint32_t)*idle << 8);
  RECORD((uintptr_t)*bytes);
  return count;
}

uint32_t rs_board_late_us(unsigned port) {
  const uint32_t late_us = REG(TIMER + TIMER_RAW) - serial_lines_came_us(port);
  RECORD(13);
  RECORD(late_us);
  return late_us;
}

void rs_board_send(unsigned port, const uint8_t* frame) {
  RECORD(6);
  RECORD(port);
  RECORD((uintptr_t)frame);
  serial_lines_send(port, frame);
}

uint32_t rs_board_sent(void) {
  const uint32_t ports = serial_lines_take_gone();
  RECORD(7);
  RECORD(ports);
  return ports;
}

/* ---- Sensors, light, memory ---- */

bool rs_board_sense(rs_sample* sample) {
  const bool fault = sensor_bus_read(sample);
  RECORD(11);
  for (unsigned channel = 0; channel < (unsigned)RS_CHANNEL_COUNT; ++channel) RECORD(sample->value[channel]);
  RECORD(fault);
  return fault;
}

void rs_board_light(uint32_t rgb) {
  RECORD(8);
  RECORD(rgb);
  show(rgb);
}

void rs_board_keep(const uint8_t* flash) {
  RECORD(9);
  RECORD((uintptr_t)flash);
  keep_image(flash);
}

void rs_board_restart(void) {
  RECORD(10);
  REG(PSM + 0x08) = 0x1FFFC; /* all but the oscillators */
  REG(WATCHDOG + SET) = 1U << 31;
  for (;;) {
  }
}
