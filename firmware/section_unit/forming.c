/* SPDX-License-Identifier: Apache-2.0
 * Whether trees are still being formed: then each cell takes the shortest way, and nothing is levelled. */
#include "section_unit/forming.h"

#include "section_unit/group_time.h"

void rs_forming_tick(rs_section_unit* unit, uint64_t now_ns) {
  const uint64_t tick = unit->tick_time;
  uint32_t cells = 0;
  for (unsigned port = 0; port < unit->config.ports; ++port) cells += unit->port[port].size;
  bool others = false, others_formed = false;
  for (unsigned u = 0; u < RS_UNITS_MAX; ++u) {
    const rs_unit_peer* peer = &unit->peer[u];
    if (!rs_peer_counts(peer, now_ns) || (peer->flags & RS_PEER_STARTING) != 0) continue;
    for (unsigned port = 0; port < RS_SECTION_UNIT_PORTS_MAX; ++port) {
      if ((peer->ports >> port & 1U) != 0U && peer->tree[port].size > 0U) others = true;
    }
    if ((peer->flags & RS_PEER_FORMING) == 0) others_formed = true;
  }
  if (cells != unit->cells) {
    if (unit->cells == 0U) unit->forming_since = tick;
    unit->cells = cells;
    unit->cells_since = tick;
  }
  if (unit->forming) {
    const bool formed = cells > 0U && tick - unit->cells_since >= RS_FORMING_TICKS &&
                        tick - unit->forming_since >= RS_FORMING_MIN_TICKS;
    unit->forming = !(formed || (others && others_formed));
  } else if (cells == 0U && !others && tick - unit->cells_since >= RS_FORMING_TICKS) {
    unit->forming = true;
    for (unsigned port = 0; port < unit->config.ports; ++port) unit->port[port].balance = (rs_unit_balance){.round = 0};
  }
}
