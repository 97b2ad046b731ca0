/* SPDX-License-Identifier: Apache-2.0
 * A cell on a chip: what the board tells becomes inputs of the cell, what the cell asks for is done. */
#include "board.h"
#include "robotskin/receiver.h"
#include RS_BOARD /* the source of the board's functions: a few instructions each, not worth a call for every input */
#include "cell/step.c"     /* likewise: the short way, */
#include "cell/wire/crc.c" /* and the checksum of every frame */

enum { PORTS_MASK = (1 << RS_PORTS) - 1 };

/* The lowest port of a set. */
static const uint8_t lowest[PORTS_MASK + 1] = {0, 0, 1, 0, 2, 0, 1, 0, 3, 0, 1, 0, 2, 0, 1, 0};

static rs_cell cell; /* the one place where a cell has an address of its own */
static rs_receiver line[RS_PORTS];
static uint8_t cut_up[RS_PORTS]; /* whether a line's receiver has had bytes that are no whole frame */
static rs_input input;
static rs_output output;

/* Carries out `input` the long way; `sent` has been noted. */
static RS_NOINLINE void step(rs_input_kind kind, uint32_t now_us) {
  input.kind = kind;
  rs_step(&cell, &input, now_us, &output);
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    if (output.frame[port] != 0) rs_board_send(port, output.frame[port]);
  }
  rs_board_alarms(output.timer_us, output.sampling, output.sample_us, output.waiting);
  if ((output.led_changed | output.flash_changed | output.restart) == 0) return;
  if (output.led_changed) rs_board_light(output.led_rgb);
  if (output.flash_changed) rs_board_keep(output.flash);
  if (output.restart) rs_board_restart();
}

/* Starts the frames of a step the short way; bit p: on port p. */
static RS_NOINLINE void start_all(unsigned started) {
  for (; started != 0U; started &= started - 1U)
    rs_board_send(lowest[started], rs_sending_last(&cell.queues, lowest[started]));
}

/* Sends what can go out, the short way. */
RS_INLINE void pass_on(unsigned ready, uint32_t now_us) {
  rs_queues* queues = &cell.queues;
  if (is_sample(queues, ready)) {
    const uint8_t* frame;
    const unsigned port = send_sample(queues, now_us, &frame);
    rs_board_send(port, frame);
  } else {
    start_all(send_anything(&cell, ready, now_us));
  }
}
static RS_NOINLINE RS_HOT void pass_on_apart(unsigned ready, uint32_t now_us) {
  pass_on(ready, now_us);
  rs_board_wanted(cell.queues.waiting);
}

/* Frames that are out count before what comes. */
RS_INLINE void note_sent(void) {
  const uint32_t sent = rs_board_sent();
  if (sent != 0U) rs_note_sent(&cell, sent);
}

/* The long way of a frame, or the short one of what comes less often; `checked`: it is known to be right. */
static RS_NOINLINE void take_the_long_way(unsigned port, const uint8_t* frame, bool checked, uint32_t now_us) {
  if (calm(&cell, now_us) && take_report(&cell, port + 1U, frame, checked, now_us)) {
    const unsigned ready = ready_to_send(&cell.queues);
    if (ready != 0U) start_all(send_anything(&cell, ready, now_us));
    rs_board_wanted(cell.queues.waiting);
    return;
  }
  input.port = (uint8_t)(port + 1U);
  input.checked = checked;
  input.late_us = (uint16_t)rs_board_late_us(port);
  input.frame = frame;
  step(RS_INPUT_FRAME, now_us);
}

/* Which frames are out the board says once, and the first input after that fills those ports anew. So the events of a
 * word that came with others may be stale, and only ask. */
static RS_NOINLINE RS_HOT void take_sent(void) {
  const uint32_t sent = rs_board_sent();
  if (sent == 0U) return;
  const uint32_t now_us = rs_board_now_us();
  rs_note_sent(&cell, sent);
  if (!calm(&cell, now_us)) {
    input.port = 0; /* all of them are noted */
    step(RS_INPUT_SENT, now_us);
    return;
  }
  const unsigned ready = ready_to_send(&cell.queues);
  if (ready != 0U) pass_on(ready, now_us);
  rs_board_wanted(cell.queues.waiting);
}

/* What is neither. */
static RS_NOINLINE void take(rs_input_kind kind) {
  note_sent();
  step(kind, rs_board_now_us());
}

/* Bytes that are not one whole frame. */
static RS_NOINLINE void receive_bytes(unsigned port, const uint8_t* bytes, uint32_t count, bool idle) {
  RS_WORDS uint8_t frame[RS_FRAME_BYTES];
  if (idle) rs_receiver_idle(&line[port]);
  for (; count > 0U; --count) {
    const rs_received received = rs_receiver_byte(&line[port], *bytes++, frame);
    if (received == RS_RECEIVED_NOTHING) continue;
    note_sent();
    take_the_long_way(port, frame, received == RS_RECEIVED_FRAME, rs_board_now_us());
  }
  cut_up[port] = !rs_receiver_at_boundary(&line[port]);
}

/* Takes what has come together; if more has, the board says so again. Nearly always that is a whole frame, right, at
 * the beginning of a word. */
static RS_NOINLINE RS_HOT void receive(unsigned port) {
  const uint8_t* bytes;
  bool idle;
  const uint32_t count = rs_board_receive(port, &bytes, &idle);
  if (count != RS_FRAME_BYTES || ((uintptr_t)bytes & 3U) != 0U || cut_up[port] || of_frame(bytes) != 0U) {
    receive_bytes(port, bytes, count, idle);
    return;
  }
  note_sent();
  const uint32_t now_us = rs_board_now_us();
  if (!calm(&cell, now_us) || !take_frame(&cell, port + 1U, bytes, true, now_us)) {
    take_the_long_way(port, bytes, true, now_us);
    return;
  }
  /* It is rare that something can go out just then. */
  const unsigned ready = ready_to_send(&cell.queues);
  if (ready == 0U) {
    rs_board_wanted(cell.queues.waiting);
  } else {
    pass_on_apart(ready, now_us);
  }
}

static void sample(void) {
  rs_sample taken;
  input.fault = rs_board_sense(&taken);
  input.sample = &taken;
  take(RS_INPUT_SAMPLE);
}

RS_HOT int main(void) {
  rs_boot boot;
  rs_board_start(&boot);
  input.boot = &boot;
  take(RS_INPUT_BOOT);
  for (;;) {
    const uint32_t events = rs_board_wait();
    for (unsigned ports = events / RS_BOARD_LINE & PORTS_MASK; ports != 0U; ports &= ports - 1U) receive(lowest[ports]);
    if (events < RS_BOARD_SENT) continue;
    if ((events / RS_BOARD_SENT & PORTS_MASK) != 0U) take_sent();
    if (events < RS_BOARD_TIMER) continue;
    if ((events & RS_BOARD_SAMPLE) != 0U) sample();
    if ((events & RS_BOARD_TIMER) != 0U) take(RS_INPUT_TIMER);
  }
}
