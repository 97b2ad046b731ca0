/* SPDX-License-Identifier: Apache-2.0
 * The upper end of a link counts the frames that must not be lost (see hearing.h). */
#include "robotskin/hearing.h"

void rs_hearing_start(rs_hearing* hearing, uint32_t number) {
  *hearing = (rs_hearing){.next = (uint8_t)(number & RS_NUMBER_MASK), .confirmed = (uint8_t)(number & RS_NUMBER_MASK)};
}

bool rs_hearing_compare(rs_hearing* hearing, uint32_t number) {
  number &= RS_NUMBER_MASK;
  if (hearing->missed) {
    if (number != hearing->confirmed) return false;
    /* The lower end has gone back. */
    hearing->next = hearing->confirmed;
    hearing->missed = false;
    return false;
  }
  hearing->missed = number != hearing->next;
  if (!hearing->missed) hearing->confirmed = hearing->next;
  return hearing->missed;
}

bool rs_hearing_first(rs_hearing* hearing, uint32_t serial) {
  const uint32_t ahead = (serial - hearing->serial) & RS_SERIAL_MASK;
  if (hearing->serials == 0U || (ahead > 0U && ahead < RS_SERIALS_REMEMBERED)) {
    hearing->serials = hearing->serials == 0U ? 1U : (uint16_t)((uint32_t)hearing->serials << ahead | 1U);
    hearing->serial = (uint8_t)(serial & RS_SERIAL_MASK);
    return true;
  }
  const uint32_t behind = (hearing->serial - serial) & RS_SERIAL_MASK;
  if (behind >= RS_SERIALS_REMEMBERED || (hearing->serials >> behind & 1U) != 0U) return false;
  hearing->serials |= (uint16_t)(1U << behind);
  return true;
}
