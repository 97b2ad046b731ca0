/* SPDX-License-Identifier: Apache-2.0
 * All trees of the group, own and heard of. */
#ifndef ROBOTSKIN_SECTION_UNIT_TREES_H
#define ROBOTSKIN_SECTION_UNIT_TREES_H

#include "robotskin/section_unit.h"

enum { RS_TREES_MAX = RS_UNITS_MAX * RS_SECTION_UNIT_PORTS_MAX, RS_TREE_WORDS = (RS_TREES_MAX + 31) / 32 };
typedef struct {
  unsigned count;
  uint8_t root[RS_TREES_MAX];
  uint8_t port[RS_TREES_MAX]; /* own: index, else RS_TREE_FOREIGN */
  uint16_t size[RS_TREES_MAX];
  uint8_t height[RS_TREES_MAX]; /* hops of the deepest cell */
  uint8_t depth_cap[RS_TREES_MAX];
  uint8_t component[RS_TREES_MAX];              /* smallest index of those it hangs together with */
  uint32_t beside[RS_TREES_MAX][RS_TREE_WORDS]; /* bit j: tree j is beside it */
} rs_trees;
enum { RS_TREE_FOREIGN = 255 };
void rs_trees_gather(rs_trees* trees, const rs_section_unit* unit, uint64_t now_ns);
bool rs_trees_beside(const rs_trees* trees, unsigned a, unsigned b);

#endif
