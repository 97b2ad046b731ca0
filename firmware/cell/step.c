/* SPDX-License-Identifier: Apache-2.0
 * The front door: an input takes the short way if it may, the long way otherwise. */
#include "cell/fast_path.h"
#include "cell/slow_path.h"
#include "cell/transmit.h"

static unsigned pass_anything(rs_cell* cell, uint32_t now_us) {
  const unsigned ready = ready_to_send(&cell->queues);
  if (ready == 0U) return 0;
  const uint8_t* frame;
  return is_sample(&cell->queues, ready) ? 1U << send_sample(&cell->queues, now_us, &frame)
                                         : send_anything(cell, ready, now_us);
}

void rs_cell_step(rs_cell* cell, const rs_input* input, uint32_t now_us, rs_output* output) {
  unsigned sent = input->sent;
  const bool is_calm = calm(cell, now_us);
  if (is_calm && input->kind == RS_INPUT_SENT && input->port <= RS_PORTS) {
    sent |= 1U << input->port >> 1;
  } else if (!is_calm || input->kind != RS_INPUT_FRAME ||
             !(take_frame(cell, input->port, input->frame, input->checked, now_us) ||
               take_report(cell, input->port, input->frame, input->checked, now_us))) {
    rs_step(cell, input, now_us, output);
    return;
  }
  rs_note_sent(cell, sent);
  rs_output_start(output, &cell->queues, pass_anything(cell, now_us));
  output->timer_us = cell->timer_us;
  output->sample_us = cell->sampling.due_us;
  output->sampling = cell->sampling.running;
  output->led_changed = output->flash_changed = output->restart = false;
  output->waiting = cell->queues.waiting;
}
