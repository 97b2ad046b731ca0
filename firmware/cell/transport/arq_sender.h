/* SPDX-License-Identifier: Apache-2.0
 * Events and torque sums, kept until they need not be sent again. */
#ifndef ROBOTSKIN_CELL_TRANSPORT_ARQ_SENDER_H
#define ROBOTSKIN_CELL_TRANSPORT_ARQ_SENDER_H

#include "cell/transport/rings.h"
#include "robotskin/cell.h"

/* Times of what is kept, in units that fit half a word. */
RS_INLINE uint16_t rs_arq_coarse(uint32_t now_us) {
  return (uint16_t)(now_us >> 6);
}
RS_INLINE uint32_t rs_arq_age_us(uint16_t time, uint32_t now_us) {
  return (uint32_t)(uint16_t)(rs_arq_coarse(now_us) - time) << 6;
}

/* Whether one of the events kept, counted from the oldest, is of no use any more: the host could not tell its time. */
RS_INLINE bool rs_arq_is_old(const rs_arq_sender* arq_sender, unsigned which, uint32_t now_us) {
  const unsigned at = (arq_sender->event.first + which) & (RS_ARQ_EVENTS - 1U);
  return rs_arq_age_us(arq_sender->event_time[at], now_us) > RS_ARQ_KEEP_US;
}
/* Whether no torque sum is to be sent or dropped now. */
RS_INLINE bool rs_arq_torques_rest(const rs_arq_sender* arq_sender, uint32_t now_us) {
  const rs_arq_ring* ring = &arq_sender->torque;
  if (ring->count == 0U) return true;
  const uint16_t oldest = arq_sender->torque_time[ring->first & (RS_ARQ_TORQUES - 1U)];
  return ring->sent >= ring->count && rs_arq_age_us(oldest, now_us) <= RS_TORQUE_RETRY_US;
}
void rs_arq_drop_old_events(rs_cell* cell, uint32_t now_us);

/* Take a frame to be sent to the parent and kept for a while; false: no room. An event that is here already counts as
 * taken; a torque sum gets its serial. */
bool rs_arq_sender_event(rs_cell* cell, const uint8_t* frame, uint32_t now_us);
bool rs_arq_sender_torque(rs_cell* cell, const rs_torque* torque, uint32_t now_us);
bool rs_arq_sender_torque_waits(const rs_cell* cell);
bool rs_arq_sender_next_event(rs_cell* cell, uint8_t* frame, uint32_t now_us);
bool rs_arq_sender_next_torque(rs_cell* cell, uint8_t* frame, uint32_t now_us);
/* A tick has come: of the parent, or of a child (`was_child`: that was one before). */
void rs_arq_sender_tick(rs_cell* cell, unsigned port, const rs_tick* tick, bool was_child, uint32_t came_us,
                        uint32_t now_us);
/* A tick of a child, which waited for the processor for so long, says that its next frame has this number: whether
 * frames are missing that it shall send again. */
bool rs_arq_missed(rs_cell* cell, unsigned port, uint32_t number, uint32_t late_us);
uint32_t rs_arq_sender_announce(rs_cell* cell); /* `ack` of the next tick to the parent */
void rs_arq_sender_check(rs_cell* cell, uint32_t now_us);

#endif
