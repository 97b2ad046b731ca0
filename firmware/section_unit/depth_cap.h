/* SPDX-License-Identifier: Apache-2.0
 * How deep balance may make the trees. */
#ifndef ROBOTSKIN_SECTION_UNIT_DEPTH_CAP_H
#define ROBOTSKIN_SECTION_UNIT_DEPTH_CAP_H

#include "robotskin/section_unit.h"
#include "section_unit/trees.h"

/* Sees whether a component with own trees has come nearer to level, and raises its cap if it has not for long. `first`
 * is the component's first tree, `lead` the port that keeps its record. */
void rs_depth_cap_watch(rs_section_unit* unit, const rs_trees* trees, unsigned first, rs_unit_balance* lead);

#endif
