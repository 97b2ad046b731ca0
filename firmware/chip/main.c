/* A cell on a chip: what the board tells becomes inputs of the cell, what the cell asks for is done. */
#include "board.h"
#include "robotskin/crc.h"
#include "robotskin/receiver.h"

static rs_cell cell; /* the one place where a cell has an address of its own */
static rs_receiver line[RS_PORTS];

static void step(rs_input* input) {
  rs_output output;
  input->sent = (uint8_t)rs_board_sent();
  rs_cell_step(&cell, input, rs_board_now_us(), &output);
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    if (output.frame[port] != 0) rs_board_send(port, output.frame[port]);
  }
  if (output.led_changed) rs_board_light(output.led_rgb);
  if (output.flash_changed) rs_board_keep(output.flash);
  rs_board_alarms(output.timer_us, output.sampling, output.sample_us, output.waiting);
  if (output.restart) rs_board_restart();
}

static void take_frame(unsigned port, const uint8_t* frame, bool intact) {
  rs_input input = {.kind = RS_INPUT_FRAME, .port = (uint8_t)(port + 1U), .checked = intact, .frame = frame};
  step(&input);
}

/* Takes what has come together; if more has, the board says so again. */
static void receive(unsigned port) {
  RS_WORDS uint8_t frame[RS_FRAME_BYTES];
  const uint8_t* bytes;
  bool idle;
  uint32_t count = rs_board_receive(port, &bytes, &idle);
  if (idle) rs_receiver_idle(&line[port]);
  while (count > 0U) {
    /* Nearly always a whole frame stands here, and needs no copy. */
    if (count >= RS_FRAME_BYTES && rs_receiver_at_boundary(&line[port]) && rs_frame_intact(bytes)) {
      take_frame(port, bytes, true);
      bytes += RS_FRAME_BYTES;
      count -= RS_FRAME_BYTES;
      continue;
    }
    const rs_received received = rs_receiver_byte(&line[port], *bytes++, frame);
    --count;
    if (received != RS_RECEIVED_NOTHING) take_frame(port, frame, received == RS_RECEIVED_FRAME);
  }
}

/* Bit p - 1 of the lowest four: port p. */
static void receive_all(uint32_t ports) {
  for (unsigned port = 0; ports != 0U; ++port, ports >>= 1) {
    if ((ports & 1U) != 0U) receive(port);
  }
}

static void finish_all(uint32_t ports) {
  for (unsigned port = 1; ports != 0U; ++port, ports >>= 1) {
    if ((ports & 1U) == 0U) continue;
    rs_input input = {.kind = RS_INPUT_SENT, .port = (uint8_t)port};
    step(&input);
  }
}

static void sample(void) {
  rs_sample taken;
  rs_input input = {.kind = RS_INPUT_SAMPLE, .sample = &taken};
  input.fault = rs_board_sense(&taken);
  step(&input);
}

int main(void) {
  rs_boot boot;
  rs_board_start(&boot);
  rs_input start = {.kind = RS_INPUT_BOOT, .boot = &boot};
  step(&start);
  enum { PORTS_MASK = (1 << RS_PORTS) - 1 };
  for (;;) {
    const uint32_t events = rs_board_wait();
    if ((events & (RS_BOARD_LINE * PORTS_MASK)) != 0U) receive_all(events / RS_BOARD_LINE & PORTS_MASK);
    if ((events & (RS_BOARD_SENT * PORTS_MASK)) != 0U) finish_all(events / RS_BOARD_SENT & PORTS_MASK);
    if ((events & RS_BOARD_SAMPLE) != 0U) sample();
    if ((events & RS_BOARD_TIMER) != 0U) {
      rs_input input = {.kind = RS_INPUT_TIMER};
      step(&input);
    }
  }
}
