/* SPDX-License-Identifier: Apache-2.0
 * The upper end of a link counts the frames that must not be lost (see arq_receiver.h). */
#include "robotskin/arq_receiver.h"

void rs_arq_receiver_start(rs_arq_receiver* arq_receiver, uint32_t number) {
  *arq_receiver =
      (rs_arq_receiver){.next = (uint8_t)(number & RS_NUMBER_MASK), .confirmed = (uint8_t)(number & RS_NUMBER_MASK)};
}

bool rs_arq_receiver_compare(rs_arq_receiver* arq_receiver, uint32_t number) {
  number &= RS_NUMBER_MASK;
  if (arq_receiver->missed) {
    if (number != arq_receiver->confirmed) return false;
    /* The lower end has gone back. */
    arq_receiver->next = arq_receiver->confirmed;
    arq_receiver->missed = false;
    return false;
  }
  arq_receiver->missed = number != arq_receiver->next;
  if (!arq_receiver->missed) arq_receiver->confirmed = arq_receiver->next;
  return arq_receiver->missed;
}

bool rs_arq_receiver_first(rs_arq_receiver* arq_receiver, uint32_t serial) {
  const uint32_t ahead = (serial - arq_receiver->serial) & RS_SERIAL_MASK;
  if (arq_receiver->serials == 0U || (ahead > 0U && ahead < RS_SERIALS_REMEMBERED)) {
    arq_receiver->serials =
        arq_receiver->serials == 0U ? 1U : (uint16_t)((uint32_t)arq_receiver->serials << ahead | 1U);
    arq_receiver->serial = (uint8_t)(serial & RS_SERIAL_MASK);
    arq_receiver->quiet = 0;
    return true;
  }
  const uint32_t behind = (arq_receiver->serial - serial) & RS_SERIAL_MASK;
  if (behind >= RS_SERIALS_REMEMBERED || (arq_receiver->serials >> behind & 1U) != 0U) return false;
  arq_receiver->serials |= (uint16_t)(1U << behind);
  arq_receiver->quiet = 0;
  return true;
}
