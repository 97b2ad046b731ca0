/* SPDX-License-Identifier: Apache-2.0
 * All trees of the group as one unit knows them: a graph, with an edge between trees that touch. */
#include "section_unit/trees.h"

#include <string.h>

#include "section_unit/group_time.h"
#include "section_unit/port.h"

bool rs_trees_beside(const rs_trees* trees, unsigned a, unsigned b) {
  return (trees->beside[a][b / 32U] >> (b % 32U) & 1U) != 0U;
}

static void add(rs_trees* trees, uint8_t root, unsigned port, const rs_peer_tree* tree) {
  const unsigned k = trees->count++;
  trees->root[k] = root;
  trees->port[k] = (uint8_t)port;
  trees->size[k] = tree->size;
  trees->height[k] = tree->height;
  trees->depth_cap[k] = tree->depth_cap;
  trees->component[k] = (uint8_t)k;
}

static void join(rs_trees* trees, unsigned k, const uint8_t* beside, const uint8_t index_of[256]) {
  for (unsigned i = 0; i < RS_PEER_NEIGHBOURS; ++i) {
    const unsigned j = index_of[beside[i]];
    if (beside[i] == 0U || j == RS_TREE_FOREIGN || j == k) continue;
    trees->beside[k][j / 32U] |= 1U << (j % 32U);
    trees->beside[j][k / 32U] |= 1U << (k % 32U);
  }
}

/* Labels spread along edges until nothing changes. */
static void label_components(rs_trees* trees) {
  bool changed = true;
  while (changed) {
    changed = false;
    for (unsigned k = 0; k < trees->count; ++k) {
      for (unsigned j = 0; j < trees->count; ++j) {
        if (trees->component[j] < trees->component[k] && rs_trees_beside(trees, k, j)) {
          trees->component[k] = trees->component[j];
          changed = true;
        }
      }
    }
  }
}

void rs_trees_gather(rs_trees* trees, const rs_section_unit* unit, uint64_t now_ns) {
  trees->count = 0;
  memset(trees->beside, 0, sizeof trees->beside);
  uint8_t index_of[256];
  memset(index_of, RS_TREE_FOREIGN, sizeof index_of);
  const uint8_t* beside[RS_TREES_MAX];
  for (unsigned port = 0; port < unit->config.ports; ++port) {
    const rs_unit_port* here = &unit->port[port];
    if (!rs_port_alive(here, now_ns)) continue;
    const rs_peer_tree tree = {
        .size = here->size, .height = here->root ? here->height + 1U : 0U, .depth_cap = here->balance.depth_cap};
    beside[trees->count] = here->balance.beside;
    index_of[rs_root_of(unit, port)] = (uint8_t)trees->count;
    add(trees, rs_root_of(unit, port), port, &tree);
  }
  for (unsigned u = 0; u < RS_UNITS_MAX; ++u) {
    const rs_unit_peer* peer = &unit->peer[u];
    if (u == unit->config.unit || !rs_peer_counts(peer, now_ns)) continue;
    for (unsigned port = 0; port < RS_SECTION_UNIT_PORTS_MAX; ++port) {
      if ((peer->ports >> port & 1U) == 0U) continue;
      const uint8_t root = rs_root_number(u, port);
      beside[trees->count] = peer->tree[port].neighbour;
      index_of[root] = (uint8_t)trees->count;
      add(trees, root, RS_TREE_FOREIGN, &peer->tree[port]);
    }
  }
  for (unsigned k = 0; k < trees->count; ++k) join(trees, k, beside[k], index_of);
  label_components(trees);
}
