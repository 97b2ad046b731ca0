/* SPDX-License-Identifier: Apache-2.0
 * Whether trees are still being formed. */
#ifndef ROBOTSKIN_SECTION_UNIT_FORMING_H
#define ROBOTSKIN_SECTION_UNIT_FORMING_H

#include "robotskin/section_unit.h"

/* Once a tick: `unit->forming` until the sizes of the trees stay as they are. */
void rs_forming_tick(rs_section_unit* unit, uint64_t now_ns);

#endif
