/* SPDX-License-Identifier: Apache-2.0
 * The chip's main loop on a board that is a script: time passes while the board is asked, so that several events stand
 * in one word, as they do on a board with interrupts. Aborts when a frame is started over one that is not out.
 *
 * Around it run a section unit at port 1 and cells at ports 2 to 4, all built for the host; random samples and orders
 * keep all lines busy. Usage: scripted_board SEED; prints what it counted. Built by test_main_loop.py. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "chip/board.h"
#include "robotskin/crc.h"
#include "robotskin/operations.h"
#include "robotskin/section_unit.h"
#include "robotskin/timing.h"

enum { END_US = 400000, RING = 16 * RS_FRAME_BYTES, SLOWEST_CALL_US = 12 };

/* A line that leads to the chip, and what sends into it. */
typedef struct {
  rs_cell cell; /* of ports 2 to 4 */
  uint32_t timer_us, sample_us;
  bool sampling;
  bool busy;
  uint32_t end_us;
  uint8_t frame[RS_FRAME_BYTES]; /* going out */
} neighbour;

/* A line that leads away from the chip. */
typedef struct {
  const uint8_t* frame; /* 0: none is going out */
  uint32_t end_us;
} outward;

static neighbour neighbours[RS_PORTS];
static outward out[RS_PORTS];
static rs_section_unit unit;
static uint64_t unit_timer_ns;
static uint32_t now_us;
static RS_WORDS uint8_t ring[RS_PORTS][RING];
static uint32_t come[RS_PORTS], taken[RS_PORTS];
static uint32_t gone, wanted, armed, wake_us[2];
static uint32_t frames, samples_up, words_of_several;
static uint64_t random_state;

static uint32_t draw(void) { /* xorshift64* (Vigna 2016) */
  random_state ^= random_state >> 12;
  random_state ^= random_state << 25;
  random_state ^= random_state >> 27;
  return (uint32_t)((random_state * 0x2545F4914F6CDD1DULL) >> 32);
}

static void require(bool holds, const char* what) {
  if (holds) return;
  fprintf(stderr, "broken at %u us: %s\n", now_us, what);
  abort();
}

/* ---- What is around the chip ---- */

static void begin(unsigned port, const uint8_t* frame) {
  memcpy(neighbours[port].frame, frame, RS_FRAME_BYTES);
  neighbours[port].busy = true;
  neighbours[port].end_us = now_us + RS_FRAME_US;
}

static void step_unit(rs_unit_input input) {
  rs_unit_output output;
  rs_section_unit_step(&unit, &input, (uint64_t)now_us * 1000U, &output);
  unit_timer_ns = output.timer_ns;
  if (output.frame[0] != NULL) begin(0, output.frame[0]);
}

static void step_cell(unsigned port, rs_input input) {
  neighbour* at = &neighbours[port];
  rs_output output;
  rs_cell_step(&at->cell, &input, now_us, &output);
  if (output.frame[0] != NULL) begin(port, output.frame[0]);
  at->timer_us = output.timer_us;
  at->sampling = output.sampling;
  at->sample_us = output.sample_us;
}

/* A sample of some cell further off, or an order to one. */
static void begin_anything(unsigned port) {
  RS_WORDS uint8_t frame[RS_FRAME_BYTES] = {0};
  if (port == 0U) {
    const rs_command order = {
        .type = RS_TYPE_command, .operation = RS_OPERATION_assign, .value_low = 1000 + draw() % 9};
    rs_command_pack(frame, &order);
  } else {
    const rs_clock sample = {.type = RS_TYPE_clock, .source = 200 + draw() % 99, .sequence = draw() % 8, .ttl = 9};
    rs_clock_pack(frame, &sample);
  }
  rs_frame_seal(frame);
  begin(port, frame);
}

static void let_neighbour_live(unsigned port) {
  neighbour* at = &neighbours[port];
  if (at->busy && now_us >= at->end_us) {
    at->busy = false;
    if (come[port] - taken[port] < RING) { /* a full ring loses the frame */
      memcpy(ring[port] + come[port] % RING, at->frame, RS_FRAME_BYTES);
      come[port] += RS_FRAME_BYTES;
    }
    if (port == 0U) {
      step_unit((rs_unit_input){.kind = RS_UNIT_INPUT_SENT, .port = 1});
    } else {
      step_cell(port, (rs_input){.kind = RS_INPUT_SENT, .port = 1});
    }
  }
  if (!at->busy && draw() % (port == 0U ? 400U : 160U) == 0U) begin_anything(port);
  if (port == 0U) {
    if ((uint64_t)now_us * 1000U >= unit_timer_ns) step_unit((rs_unit_input){.kind = RS_UNIT_INPUT_TIMER});
    return;
  }
  const rs_sample sample = {.value = {(int32_t)(now_us / 1000U)}};
  if (at->sampling && (int32_t)(now_us - at->sample_us) >= 0) {
    step_cell(port, (rs_input){.kind = RS_INPUT_SAMPLE, .sample = &sample});
  } else if ((int32_t)(now_us - at->timer_us) >= 0) {
    step_cell(port, (rs_input){.kind = RS_INPUT_TIMER});
  }
}

static void end_frame(unsigned port) {
  const uint8_t* frame = out[port].frame;
  require(rs_frame_intact(frame), "a frame stays as it is until it is out");
  samples_up += port == 0U && rs_frame_type_of(frame) == RS_TYPE_clock;
  out[port].frame = NULL;
  gone |= 1U << port;
  if (port == 0U) {
    step_unit((rs_unit_input){.kind = RS_UNIT_INPUT_FRAME, .port = 1, .bytes = frame});
  } else {
    step_cell(port, (rs_input){.kind = RS_INPUT_FRAME, .port = 1, .frame = frame});
  }
}

static void pass(uint32_t us) {
  for (; us > 0U; --us) {
    ++now_us;
    for (unsigned port = 0; port < RS_PORTS; ++port) {
      if (out[port].frame != NULL && now_us >= out[port].end_us) end_frame(port);
      let_neighbour_live(port);
    }
  }
  if (now_us < END_US) return;
  printf("frames %u samples %u several %u\n", frames, samples_up, words_of_several);
  exit(0);
}

static void build_skin(void) {
  static const rs_section_unit_config config = {
      .group = 1, .ports = 1, .first_id = 1, .last_id = 99, .batch_us = 1000, .session = 9, .powered = true};
  step_unit((rs_unit_input){.kind = RS_UNIT_INPUT_BOOT, .config = &config});
  for (unsigned port = 1; port < RS_PORTS; ++port) {
    const rs_boot boot = {.uid = 50 + port, .random = draw()};
    step_cell(port, (rs_input){.kind = RS_INPUT_BOOT, .boot = &boot});
  }
}

/* ---- The board ---- */

void rs_board_start(rs_boot* boot) {
  build_skin();
  *boot = (rs_boot){.uid = 7, .random = draw()};
}

uint32_t rs_board_now_us(void) {
  pass(draw() % SLOWEST_CALL_US);
  return now_us;
}

void rs_board_alarms(uint32_t timer_us, bool sampling, uint32_t sample_us, uint32_t ports) {
  wake_us[0] = timer_us;
  wake_us[1] = sample_us;
  armed = (uint32_t)RS_BOARD_TIMER | (sampling ? (uint32_t)RS_BOARD_SAMPLE : 0U);
  wanted = ports;
}

void rs_board_wanted(uint32_t ports) {
  wanted = ports;
}

uint32_t rs_board_wait(void) {
  for (;;) {
    uint32_t events = (gone & wanted) * RS_BOARD_SENT;
    for (unsigned port = 0; port < RS_PORTS; ++port) events |= (uint32_t)(come[port] != taken[port]) << port;
    for (unsigned i = 0; i < 2U; ++i) {
      const uint32_t event = (uint32_t)RS_BOARD_TIMER << i;
      if ((armed & event) != 0U && (int32_t)(now_us - wake_us[i]) >= 0) events |= event;
    }
    armed &= ~events;
    words_of_several += (events & (events - 1U)) != 0U;
    if (events != 0U) return events;
    pass(1);
  }
}

uint32_t rs_board_receive(unsigned port, const uint8_t** bytes, bool* idle) {
  pass(draw() % SLOWEST_CALL_US);
  *bytes = ring[port] + taken[port] % RING;
  *idle = true;
  if (come[port] == taken[port]) return 0;
  taken[port] += RS_FRAME_BYTES;
  return RS_FRAME_BYTES;
}

uint32_t rs_board_late_us(unsigned port) {
  (void)port;
  return 0;
}

void rs_board_send(unsigned port, const uint8_t* frame) {
  pass(draw() % 3U);
  require(out[port].frame == NULL, "a frame is started over another one");
  ++frames;
  gone &= ~(1U << port);
  out[port] = (outward){.frame = frame, .end_us = now_us + RS_FRAME_US};
}

uint32_t rs_board_sent(void) {
  const uint32_t ports = gone;
  gone = 0;
  return ports;
}

bool rs_board_sense(rs_sample* sample) {
  *sample = (rs_sample){.value = {(int32_t)(now_us / 1000U)}};
  return false;
}

void rs_board_light(uint32_t rgb) {
  (void)rgb;
}

void rs_board_keep(const uint8_t* flash) {
  (void)flash;
}

void rs_board_restart(void) {
  require(false, "the chip starts anew for no reason");
}

/* ---- The program ---- */

int run_chip(void); /* main of main.c, which is built with that name */

int main(int count, char** arguments) {
  random_state = 0x9E3779B97F4A7C15ULL ^ (count > 1 ? strtoull(arguments[1], NULL, 10) : 1U);
  return run_chip();
}
