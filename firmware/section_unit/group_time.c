/* SPDX-License-Identifier: Apache-2.0
 * The time that the units of a group agree on, and which of them count. */
#include "section_unit/group_time.h"

enum { NS_PER_US = 1000 };

uint64_t rs_unit_time(const rs_section_unit* unit, uint64_t now_ns) {
  return now_ns + unit->ahead_ns;
}

bool rs_peer_counts(const rs_unit_peer* peer, uint64_t now_ns) {
  return peer->heard && peer->mutual && now_ns - peer->heard_ns < (uint64_t)RS_PEER_SILENCE_US * NS_PER_US;
}
