/* SPDX-License-Identifier: Apache-2.0
 * The board of QEMU's machine mps2-an385: four of its five serial lines (CMSDK UARTs) are the cell's ports, one of its
 * timers is the clock, another one the alarm. Its code and data memory lie where cortex_m0plus.ld puts ours.
 *
 * It has interrupts where a port to hardware would have direct memory access, no sensors, so it counts samples, and
 * what is written to flash stays until the machine is switched off. Outside run other machines and programs in real
 * time, of which none keeps microseconds: the cell's clock is RS_BOARD_SLOWER times slower than the machine's. */
#include "board.h"

#ifndef RS_BOARD_SLOWER
#define RS_BOARD_SLOWER 1
#endif

enum {
  TICKS_PER_US = 25 * RS_BOARD_SLOWER, /* of a processor at 25 MHz */
  LONGEST_WAIT_US = 10000,             /* of one alarm, so that its ticks fit a word */
  WAITING_BYTES = 8 * RS_FRAME_BYTES,  /* of a port */
  COUNTED = 101                        /* what stands for sensors counts round so many */
};

/* ---- Registers ---- */

typedef struct {
  volatile uint32_t data, state, control, interrupts, divider;
} uart;
enum {
  UART_SEND = 1 << 0,
  UART_RECEIVE = 1 << 1,
  UART_TELL_SENT = 1 << 2,
  UART_TELL_RECEIVED = 1 << 3,
  UART_HAS_BYTE = 1 << 1, /* of `state` */
  UART_SENT = 1 << 0,     /* of `interrupts`, where a one written ends it */
  UART_RECEIVED = 1 << 1,
  UART_LEAST_DIVIDER = 16
};

typedef struct {
  volatile uint32_t control, value, reload, interrupt;
} timer;
enum { TIMER_RUNS = 1 << 0, TIMER_TELLS = 1 << 3 };

typedef struct {
  uint32_t uid, random;
  uint32_t keyed; /* not 0: there are keys */
  uint8_t keys[RS_CELL_KEYS_BYTES];
} fuses; /* what a part is told when it is made */

static uart* const lines[RS_PORTS] = {(uart*)0x40004000U, (uart*)0x40005000U, (uart*)0x40006000U, (uart*)0x40007000U};
static timer* const running_clock = (timer*)0x40000000U;
static timer* const alarm = (timer*)0x40001000U;
static volatile uint32_t* const lights = (volatile uint32_t*)0x40028000U;
static volatile uint32_t* const interrupts_enabled = (volatile uint32_t*)0xE000E100U;
static volatile uint32_t* const reset_control = (volatile uint32_t*)0xE000ED0CU;
static const fuses* const made_with = (const fuses*)0x20003000U; /* behind the memory of the part that is played */

enum {
  ALARM_INTERRUPT = 9,
  INTERRUPTS = 1 << 0 | 1 << 1 | 1 << 2 | 1 << 3 | 1 << 4 | 1 << 5 | 1 << ALARM_INTERRUPT | 1 << 18 | 1 << 19,
  RESET_REQUEST = 0x05FA0004,
  KEPT_BYTES = 1024
};

extern uint8_t rs_kept_start[KEPT_BYTES];

/* Of an interrupt of a line: its port. That a byte has come has the even number, that one has gone the odd one. */
static unsigned port_of(unsigned interrupt) {
  return interrupt < 6U ? interrupt / 2U : 3U;
}

/* ---- What interrupts and main loop share ---- */

typedef struct {
  RS_WORDS uint8_t bytes[WAITING_BYTES];
  volatile uint32_t come;    /* bytes, in all */
  volatile uint32_t free_to; /* how many may have come before one finds no room */
  uint32_t taken;
} inward;

typedef struct {
  const uint8_t* volatile next;
  volatile uint32_t left;
  volatile bool busy;
} outward;

static inward in[RS_PORTS];
static outward out[RS_PORTS];
static volatile uint32_t gone; /* bit p - 1: the frame on port p */
static uint32_t wanted;
static uint32_t wake_us[2]; /* timer, sample */
static uint32_t armed;      /* of those, RS_BOARD_TIMER and RS_BOARD_SAMPLE */

static void byte_has_come(unsigned port) {
  inward* from = &in[port];
  while ((lines[port]->state & UART_HAS_BYTE) != 0U) {
    const uint8_t byte = (uint8_t)lines[port]->data;
    lines[port]->interrupts = UART_RECEIVED;
    if (from->come == from->free_to) continue; /* the receiver finds the next frame all the same */
    from->bytes[from->come % WAITING_BYTES] = byte;
    ++from->come;
  }
  lines[port]->interrupts = UART_RECEIVED;
}

static void byte_has_gone(unsigned port) {
  outward* to = &out[port];
  lines[port]->interrupts = UART_SENT;
  if (!to->busy) return;
  if (to->left > 0U) {
    --to->left;
    lines[port]->data = *to->next++;
  } else {
    to->busy = false;
    gone |= 1U << port;
  }
}

void rs_interrupt(void) {
  uint32_t number;
  __asm__ volatile("mrs %0, ipsr" : "=r"(number));
  number -= 16U;
  if (number == ALARM_INTERRUPT) {
    alarm->control = 0;
    alarm->interrupt = 1;
  } else if (number % 2U == 0U) {
    byte_has_come(port_of(number));
  } else {
    byte_has_gone(port_of(number));
  }
}

static void hold_interrupts(void) {
  __asm__ volatile("cpsid i" ::: "memory");
}

static void let_interrupts(void) {
  __asm__ volatile("cpsie i" ::: "memory");
}

/* ---- What board.h asks for ---- */

static bool is_kept(void) {
  return rs_kept_start[KEPT_BYTES - 1] == 1U;
}

void rs_board_start(rs_boot* boot) {
  running_clock->reload = running_clock->value = UINT32_MAX;
  running_clock->control = TIMER_RUNS;
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    in[port].free_to = WAITING_BYTES;
    lines[port]->divider = UART_LEAST_DIVIDER;
    lines[port]->control = UART_SEND | UART_RECEIVE | UART_TELL_SENT | UART_TELL_RECEIVED;
  }
  *interrupts_enabled = INTERRUPTS;
  boot->uid = made_with->uid != 0U ? made_with->uid : 1U;
  boot->random = made_with->random;
  boot->flash = is_kept() ? rs_kept_start : 0;
  boot->keys = made_with->keyed != 0U ? made_with->keys : 0;
  boot->step_us = 0; /* the clock is slowed so far that a step takes no time by it */
}

/* Called often enough for the timer, which goes round in 171 s. */
uint32_t rs_board_now_us(void) {
  static uint32_t now_us, counted;
  const uint32_t elapsed_us = (UINT32_MAX - running_clock->value - counted) / TICKS_PER_US;
  now_us += elapsed_us;
  counted += elapsed_us * TICKS_PER_US;
  return now_us;
}

void rs_board_wanted(uint32_t ports) {
  wanted = ports;
}

void rs_board_alarms(uint32_t timer_us, bool sampling, uint32_t sample_us, uint32_t ports) {
  wake_us[0] = timer_us;
  wake_us[1] = sample_us;
  armed = RS_BOARD_TIMER | (sampling ? RS_BOARD_SAMPLE : 0);
  wanted = ports;
}

/* What has happened and is not waited for any more from now on. */
static uint32_t take_events(void) {
  uint32_t events = 0;
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    if (in[port].come - in[port].taken >= RS_FRAME_BYTES) events |= (uint32_t)RS_BOARD_LINE << port;
  }
  events |= (gone & wanted) * RS_BOARD_SENT;
  const uint32_t now_us = rs_board_now_us();
  for (unsigned i = 0; i < 2U; ++i) {
    const uint32_t event = (uint32_t)RS_BOARD_TIMER << i;
    if ((armed & event) != 0U && (int32_t)(now_us - wake_us[i]) >= 0) events |= event;
  }
  armed &= ~events;
  return events;
}

static void set_alarm(void) {
  const uint32_t now_us = rs_board_now_us();
  uint32_t wait_us = LONGEST_WAIT_US;
  for (unsigned i = 0; i < 2U; ++i) {
    if ((armed & (uint32_t)RS_BOARD_TIMER << i) != 0U && wake_us[i] - now_us < wait_us) wait_us = wake_us[i] - now_us;
  }
  alarm->control = 0;
  alarm->reload = alarm->value = (wait_us + 1U) * TICKS_PER_US;
  alarm->control = TIMER_RUNS | TIMER_TELLS;
}

uint32_t rs_board_wait(void) {
  for (;;) {
    hold_interrupts(); /* one that comes from here on ends the sleep */
    const uint32_t events = take_events();
    if (events == 0U) {
      set_alarm();
      __asm__ volatile("wfi" ::: "memory");
    }
    let_interrupts();
    if (events != 0U) return events;
  }
}

/* A frame's length at a time: as long as no byte is lost, that is a frame, at the beginning of a word. */
uint32_t rs_board_receive(unsigned port, const uint8_t** bytes, bool* idle) {
  inward* from = &in[port];
  *bytes = from->bytes + from->taken % WAITING_BYTES;
  *idle = false; /* it is not known here how long the line was silent */
  from->free_to = from->taken + WAITING_BYTES;
  if (from->come - from->taken < RS_FRAME_BYTES) return 0;
  from->taken += RS_FRAME_BYTES;
  return RS_FRAME_BYTES;
}

uint32_t rs_board_late_us(unsigned port) {
  (void)port;
  return 0; /* as of step_us */
}

void rs_board_send(unsigned port, const uint8_t* frame) {
  outward* to = &out[port];
  hold_interrupts();
  to->busy = true;
  to->left = RS_FRAME_BYTES - 1;
  to->next = frame + 1;
  gone &= ~(1U << port);
  lines[port]->data = frame[0];
  let_interrupts();
}

uint32_t rs_board_sent(void) {
  hold_interrupts();
  const uint32_t ports = gone;
  gone = 0;
  let_interrupts();
  return ports;
}

bool rs_board_sense(rs_sample* sample) {
  static uint32_t count;
  for (unsigned channel = 0; channel < RS_CHANNEL_ALL_COUNT; ++channel) {
    sample->value[channel] = (int32_t)((count + 7U * channel) % COUNTED);
  }
  count = (count + 1U) % COUNTED;
  return false;
}

void rs_board_light(uint32_t rgb) {
  *lights = rgb != 0U;
}

void rs_board_keep(const uint8_t* flash) {
  for (unsigned i = 0; i < RS_FLASH_BYTES; ++i) rs_kept_start[i] = flash[i];
  rs_kept_start[KEPT_BYTES - 1] = 1;
}
RS_STATIC_ASSERT((int)RS_FLASH_BYTES < (int)KEPT_BYTES, "the last byte says that there is an image");

void rs_board_restart(void) {
  *reset_control = RESET_REQUEST;
  for (;;) {
  }
}
