/* SPDX-License-Identifier: Apache-2.0
 * The registers of the RP2040 that the cell uses, by the names of its data sheet. */
#ifndef ROBOTSKIN_RP2040_H
#define ROBOTSKIN_RP2040_H

#include <stdint.h>

#define REG(address) (*(volatile uint32_t*)(address))

enum {
  SET = 0x2000, /* beside a register: sets the bits that are written, */
  CLR = 0x3000, /* clears them */

  RESETS = 0x4000C000,
  CLOCKS = 0x40008000,
  PSM = 0x40010000,
  IO_BANK0 = 0x40014000,
  PADS = 0x4001C000,
  XOSC = 0x40024000,
  PLL_SYS = 0x40028000,
  PLL_USB = 0x4002C000,
  I2C0 = 0x40044000,
  ADC = 0x4004C000,
  PWM = 0x40050000,
  TIMER = 0x40054000,
  TIMER_RAW = 0x28,
  WATCHDOG = 0x40058000,
  ROSC = 0x40060000,
  DMA = 0x50000000,
  PIO0 = 0x50200000,
  PIO1 = 0x50300000,

  /* of RESETS */
  RESET_ADC = 1 << 0,
  RESET_DMA = 1 << 2,
  RESET_I2C0 = 1 << 3,
  RESET_IO = 1 << 5,
  RESET_PADS = 1 << 8,
  RESET_PIO0 = 1 << 10,
  RESET_PIO1 = 1 << 11,
  RESET_PLL_SYS = 1 << 12,
  RESET_PLL_USB = 1 << 13,
  RESET_PWM = 1 << 14,
  RESET_TIMER = 1 << 21,

  DMA_CHANNEL = 0x40, /* bytes of a channel's registers: */
  DMA_READ = 0x00,
  DMA_WRITE = 0x04,
  DMA_COUNT = 0x08,
  DMA_CONTROL_TRIGGER = 0x0C,
  DMA_CONTROL = 0x10,
  DMA_WRITE_TRIGGER = 0x2C,
  DMA_READ_TRIGGER = 0x3C,
  DMA_INTE0 = 0x404,
  DMA_INTS0 = 0x40C,
  DMA_ABORT = 0x444,
  DMA_BUSY = 1 << 24,

  IRQ_TIMER0 = 0,
  IRQ_PIO0 = 7,
  IRQ_PIO1 = 9,
  IRQ_DMA0 = 11,
  IRQ_I2C0 = 23,

  /* What a pin does */
  PIN_I2C = 3,
  PIN_PWM = 4,
  PIN_PIO0 = 6,
  PIN_PIO1 = 7,
  PAD_INPUT_PULLED_UP = 1 << 6 | 1 << 3 | 1 << 1
};

#endif
