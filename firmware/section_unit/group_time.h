/* SPDX-License-Identifier: Apache-2.0
 * The time that the units of a group agree on. */
#ifndef ROBOTSKIN_SECTION_UNIT_GROUP_TIME_H
#define ROBOTSKIN_SECTION_UNIT_GROUP_TIME_H

#include "robotskin/section_unit.h"

uint64_t rs_unit_time(const rs_section_unit* unit, uint64_t now_ns); /* the group's time at an own time */
bool rs_peer_counts(const rs_unit_peer* peer, uint64_t now_ns);      /* both hear each other */

#endif
