/* SPDX-License-Identifier: Apache-2.0 */
#include "serial_lines.h"

#include "robotskin/cell.h"
#include "rp2040.h"

enum {
  SENDS_AT = 2, /* pins */
  HEARS_AT = 6,
  BLOCKS = 64, /* of a line: 3 ms, as long as it takes to write the flash */
  IDLE_POLLS = 319,

  PIO_CTRL = 0x00,
  PIO_TXF = 0x10,
  PIO_RXF = 0x20,
  PIO_IRQ = 0x30,
  PIO_MEMORY = 0x48,
  PIO_SM = 0xC8,
  PIO_SM_SIZE = 0x18,
  PIO_INTE0 = 0x12C
};

/* 32 cycles a bit: divider 4, 8 cycles each. Sends 20 bytes, and tells two bytes before their end, so that the next
 * frame follows without a gap. Takes 32 bits at a time; side-set 1, optional. */
static const uint16_t sends[] = {
    0xF851, /* 0 set y, 17             side 1     */
    0x98E0, /* 1 pull ifempty block    side 1     */
    0xF727, /* 2 set x, 7              side 0 [7] */
    0x6001, /* 3 out pins, 1                      */
    0x0643, /* 4 jmp x-- 3                    [6] */
    0x1F82, /* 5 jmp y-- 2             side 1 [7] */
    0xC010, /* 6 irq nowait 0 rel                 */
    0xE041, /* 7 set y, 1                         */
    0xF727, /* 8 set x, 7              side 0 [7] */
    0x6001, /* 9 out pins, 1                      */
    0x0649, /* 10 jmp x-- 9                   [6] */
    0x1F88  /* 11 jmp y-- 8            side 1 [7] */
};
/* 32 cycles a bit, undivided. After 20 bit times without a byte it says that the line is idle. The pins' synchroniser
 * takes two cycles, so the wait before a sample is 10. */
static const uint16_t hears[] = {
    0x20A0, /* 0 wait 1 pin 0       */
    0xA047, /* 1 mov y, osr         */
    0x00C4, /* 2 jmp pin 4          */
    0x0007, /* 3 jmp 7              */
    0x0082, /* 4 jmp y-- 2          */
    0xC010, /* 5 irq nowait 0 rel   */
    0x2020, /* 6 wait 0 pin 0       */
    0xFF27, /* 7 set x, 7      [31] */
    0xAA42, /* 8 nop           [10] */
    0x4001, /* 9 in pins, 1         */
    0x1E49  /* 10 jmp x-- 9    [30] */
};

typedef struct {
  RS_WORDS uint8_t bytes[BLOCKS][RS_FRAME_BYTES];
  volatile uint8_t length[BLOCKS], after_idle[BLOCKS];
  volatile uint32_t came_us[BLOCKS]; /* when it was closed */
  volatile uint32_t come;            /* blocks that are closed */
  uint32_t taken;
} inward;
static inward in[RS_PORTS];
static volatile uint32_t gone;

static uint32_t hearing(unsigned port) {
  return DMA + DMA_CHANNEL * port;
}
static uint32_t sending(unsigned port) {
  return DMA + DMA_CHANNEL * (RS_PORTS + port);
}

static void point_on(unsigned port) { /* to the block after those that are closed */
  in[port].after_idle[in[port].come % BLOCKS] = 0;
  REG(hearing(port) + DMA_WRITE_TRIGGER) = (uint32_t)(uintptr_t)in[port].bytes[in[port].come % BLOCKS];
}

static void close_block(unsigned port, uint32_t length) {
  in[port].length[in[port].come % BLOCKS] = (uint8_t)length;
  in[port].came_us[in[port].come % BLOCKS] = REG(TIMER + TIMER_RAW);
  ++in[port].come;
  point_on(port);
}

/* A block that has begun is cut off here: the next frame begins a block. */
static void line_is_idle(unsigned port) {
  const uint32_t left = REG(hearing(port) + DMA_COUNT);
  if (left != RS_FRAME_BYTES && left != 0U) {
    REG(DMA + CLR + DMA_INTE0) = 1U << port; /* RP2040-E13: an abort may ring falsely */
    REG(DMA + DMA_ABORT) = 1U << port;
    while ((REG(hearing(port) + DMA_CONTROL) & DMA_BUSY) != 0U) {
    }
    REG(DMA + DMA_INTS0) = 1U << port;
    REG(DMA + SET + DMA_INTE0) = 1U << port;
    close_block(port, RS_FRAME_BYTES - left);
  }
  in[port].after_idle[in[port].come % BLOCKS] = 1;
}

void serial_lines_interrupt(uint32_t number) {
  if (number == IRQ_DMA0) {
    const uint32_t done = REG(DMA + DMA_INTS0);
    REG(DMA + DMA_INTS0) = done;
    for (unsigned port = 0; port < RS_PORTS; ++port) {
      if ((done >> port & 1U) != 0U) close_block(port, RS_FRAME_BYTES);
    }
    return;
  }
  const uint32_t pio = number == IRQ_PIO0 ? PIO0 : PIO1;
  const uint32_t flags = REG(pio + PIO_IRQ) & 15U;
  REG(pio + PIO_IRQ) = flags;
  if (number == IRQ_PIO0) {
    gone |= flags;
    return;
  }
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    if ((flags >> port & 1U) != 0U) line_is_idle(port);
  }
}

static void set_machine(uint32_t machine, uint32_t divider, uint32_t exec, uint32_t shift, uint32_t pins) {
  REG(machine + 0x00) = divider << 16;
  REG(machine + 0x04) = exec;
  REG(machine + 0x08) = shift;
  REG(machine + 0x14) = pins;
}

static void start_sender(unsigned port) {
  const uint32_t machine = PIO0 + PIO_SM + PIO_SM_SIZE * port, pin = SENDS_AT + port, channel = sending(port);
  set_machine(machine, 4, 1U << 30 | 11U << 12, 1U << 30 | 1U << 19 | 1U << 17,
              2U << 29 | 1U << 26 | 1U << 20 | pin << 10 | pin << 5 | pin);
  REG(machine + 0x10) = 0xE001; /* set pins, 1 */
  REG(machine + 0x10) = 0xE081; /* set pindirs, 1 */
  REG(IO_BANK0 + 8 * pin + 4) = PIN_PIO0;
  REG(channel + DMA_WRITE) = PIO0 + PIO_TXF + 4 * port;
  REG(channel + DMA_COUNT) = RS_FRAME_BYTES / 4;
  REG(channel + DMA_CONTROL) = port << 15 | (RS_PORTS + port) << 11 | 1U << 21 | 1U << 4 | 2U << 2 | 1U;
}

static void start_hearer(unsigned port) {
  const uint32_t machine = PIO1 + PIO_SM + PIO_SM_SIZE * port, pin = HEARS_AT + port, channel = hearing(port);
  const uint32_t exec = pin << 24 | 10U << 12;
  set_machine(machine, 1, exec, 0, pin << 15);
  REG(PIO1 + PIO_TXF + 4 * port) = IDLE_POLLS;
  REG(machine + 0x10) = 0x80A0; /* pull block: it stays in the register for good */
  set_machine(machine, 1, exec, 1U << 31 | 8U << 20 | 1U << 18 | 1U << 16, pin << 15);
  REG(IO_BANK0 + 8 * pin + 4) = PIN_PIO1;
  REG(PADS + 4 + 4 * pin) = PAD_INPUT_PULLED_UP;
  REG(channel + DMA_READ) = PIO1 + PIO_RXF + 4 * port + 3;
  REG(channel + DMA_COUNT) = RS_FRAME_BYTES;
  REG(channel + DMA_CONTROL) = (12U + port) << 15 | port << 11 | 1U << 5 | 1U;
  point_on(port);
}

void serial_lines_start(void) {
  for (unsigned i = 0; i < sizeof sends / sizeof *sends; ++i) REG(PIO0 + PIO_MEMORY + 4 * i) = sends[i];
  for (unsigned i = 0; i < sizeof hears / sizeof *hears; ++i) REG(PIO1 + PIO_MEMORY + 4 * i) = hears[i];
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    start_sender(port);
    start_hearer(port);
  }
  REG(DMA + DMA_INTE0) = 15;
  REG(PIO0 + PIO_INTE0) = 15U << 8;
  REG(PIO1 + PIO_INTE0) = 15U << 8;
  REG(PIO0 + PIO_CTRL) = 15U << 4 | 15U;
  REG(PIO1 + PIO_CTRL) = 15U;
}

uint32_t serial_lines_come(void) {
  uint32_t ports = 0;
  for (unsigned port = 0; port < RS_PORTS; ++port) ports |= (uint32_t)(in[port].come != in[port].taken) << port;
  return ports;
}

uint32_t serial_lines_gone(void) {
  return gone;
}

uint32_t serial_lines_take_gone(void) {
  __asm__ volatile("cpsid i" ::: "memory");
  const uint32_t ports = gone;
  gone = 0;
  __asm__ volatile("cpsie i" ::: "memory");
  return ports;
}

uint32_t serial_lines_receive(unsigned port, const uint8_t** bytes, bool* idle) {
  inward* from = &in[port];
  if (from->come - from->taken >= BLOCKS) from->taken = from->come - (BLOCKS - 2); /* too late for the oldest */
  *idle = false;
  *bytes = from->bytes[0];
  if (from->come == from->taken) return 0;
  const uint32_t at = from->taken++ % BLOCKS;
  *bytes = from->bytes[at];
  *idle = from->after_idle[at] != 0U;
  return from->length[at];
}

uint32_t serial_lines_came_us(unsigned port) {
  return in[port].came_us[(in[port].taken - 1U) % BLOCKS];
}

void serial_lines_send(unsigned port, const uint8_t* frame) {
  __asm__ volatile("cpsid i" ::: "memory");
  gone &= ~(1U << port);
  __asm__ volatile("cpsie i" ::: "memory");
  REG(sending(port) + DMA_READ_TRIGGER) = (uint32_t)(uintptr_t)frame;
}
