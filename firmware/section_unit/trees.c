/* SPDX-License-Identifier: Apache-2.0
 * All trees of the group as one unit knows them, and the potentials that say how to level them.
 *
 * Trees that touch are the nodes of a graph. The flows along its edges that level all sizes with the least sum of
 * squares are the differences of potentials p with L p = size - mean, L the graph's Laplacian; Gauss-Seidel steps solve
 * it, a few each round, as sizes change slowly. Potential differences point one way only along every path, so two trees
 * never want cells from each other, and nothing goes round in circles. */
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

static void relax_component(const rs_trees* trees, unsigned first, int64_t potential[256]) {
  uint8_t member[RS_TREES_MAX];
  unsigned count = 0;
  int64_t total = 0;
  for (unsigned k = first; k < trees->count; ++k) {
    if (trees->component[k] != first) continue;
    member[count++] = (uint8_t)k;
    total += trees->size[k];
  }
  if (count < 2U) return;
  const int64_t mean = total * RS_POTENTIAL_SCALE / (int64_t)count;
  unsigned sweeps = 8192U / (count * count);
  if (sweeps > 200U) sweeps = 200;
  if (sweeps < 16U) sweeps = 16;
  int64_t sum = 0;
  for (unsigned sweep = 0; sweep < sweeps; ++sweep) {
    sum = 0;
    for (unsigned i = 0; i < count; ++i) {
      const unsigned k = member[i];
      int64_t above = (int64_t)trees->size[k] * RS_POTENTIAL_SCALE - mean, degree = 0;
      for (unsigned j = 0; j < count; ++j) {
        if (!rs_trees_beside(trees, k, member[j])) continue;
        above += potential[trees->root[member[j]]];
        ++degree;
      }
      potential[trees->root[k]] = above / degree;
      sum += potential[trees->root[k]];
    }
  }
  for (unsigned i = 0; i < count; ++i) potential[trees->root[member[i]]] -= sum / (int64_t)count;
}

void rs_trees_relax(const rs_trees* trees, int64_t potential[256]) {
  for (unsigned k = 0; k < trees->count; ++k) {
    if (trees->component[k] == k) relax_component(trees, k, potential);
  }
}
