/* SPDX-License-Identifier: Apache-2.0
 * The rule on which loop freedom rests, in a header of its own: the cells route by it, and the model check explores
 * this very text on every small network (core/campaign/model_check.hpp).
 *
 * A distance is a tick's sequence number and hops. One comes before another if its sequence is newer, or equal with
 * fewer hops. A cell's feasible distance is the foremost it ever had; a beacon may be adopted only if it comes
 * strictly before that (the feasibility condition of DUAL, Garcia-Luna-Aceves 1993, with the sequence numbers of Babel,
 * RFC 8966, section 2.4 and 2.5). */
#ifndef ROBOTSKIN_FEASIBILITY_H
#define ROBOTSKIN_FEASIBILITY_H

#include <stdbool.h>
#include <stdint.h>

#include "robotskin/wire.h"

typedef struct {
  uint16_t sequence;
  uint8_t hops;
} rs_distance;

/* Whether sequence number a comes after b (RFC 1982). */
RS_INLINE bool rs_newer(uint16_t a, uint16_t b) {
  const uint16_t ahead = (uint16_t)(a - b);
  return ahead != 0U && ahead < 0x8000U;
}

/* R2: whether a cell with this feasible distance (`unbound`: none yet) may adopt a neighbour that announces `offer`.
 */
RS_INLINE bool rs_feasible(bool unbound, rs_distance bound, rs_distance offer) {
  if (offer.hops >= RS_HOPS_MAX) return false;
  if (unbound || rs_newer(offer.sequence, bound.sequence)) return true;
  return offer.sequence == bound.sequence && offer.hops < bound.hops;
}

#endif
