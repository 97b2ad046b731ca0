/* SPDX-License-Identifier: Apache-2.0
 * What a cell says of itself: it asks for an id, and reports its neighbours. */
#include "cell/routing/identity.h"

#include "cell/memory/integrity.h"
#include "cell/routing/wrong_tags.h"
#include "cell/time/clock.h"
#include "cell/time/sample_clock.h"
#include "cell/time/spread.h"
#include "cell/transport/queues.h"
#include "cell/wire/ports.h"
#include "robotskin/crc.h"

/* A new challenge, so that an `assign` recorded earlier no longer fits. */
static void draw_challenge(rs_cell* cell, uint32_t random) {
  cell->challenge = (uint16_t)rs_spread(random ^ cell->uid ^ ((uint32_t)cell->challenge << 16));
}

void rs_identity_boot(rs_cell* cell, uint32_t random, uint32_t now_us) {
  cell->nonce = (uint8_t)rs_spread(random);
  draw_challenge(cell, random);
  cell->topology_us = now_us + rs_spread(cell->uid) % RS_TOPOLOGY_US;
  cell->join_us = now_us;
}

void rs_identity_changed(rs_cell* cell, uint32_t now_us) {
  /* Changes come to many cells at once; their reports do not, and one report tells all changes of a while. */
  const uint32_t soon_us =
      now_us + RS_TOPOLOGY_PAUSE_US + rs_spread(cell->uid + cell->topology_revision) % RS_TOPOLOGY_SPREAD_US;
  ++cell->topology_revision;
  if (!rs_reached(soon_us, cell->topology_us)) cell->topology_us = soon_us;
}

void rs_identity_assign(rs_cell* cell, uint16_t id, uint32_t now_us) {
  draw_challenge(cell, now_us);
  if (cell->id == id) return;
  cell->id = id;
  rs_cell_seal(cell);
  rs_identity_changed(cell, now_us);
  rs_sampling_restart(cell, now_us);
  cell->queues.beacon_due = RS_ALL_PORTS; /* neighbours learn the name */
}

void rs_identity_rejoin(rs_cell* cell, uint32_t now_us) {
  draw_challenge(cell, now_us);
  cell->id = RS_ID_NONE;
  rs_cell_seal(cell);
  cell->join_us = now_us;
  rs_sampling_restart(cell, now_us);
  cell->queues.beacon_due = RS_ALL_PORTS;
}

/* Binary digits of the count, at most 7; 0 for none. */
static uint32_t binary_digits(uint32_t count) {
  uint32_t result = 0;
  for (; count != 0U && result < 7U; count >>= 1) ++result;
  return result;
}

static void report_topology(rs_cell* cell, uint32_t now_us) {
  const rs_neighbour* neighbour = cell->route.neighbour;
  uint32_t id[RS_PORTS], port[RS_PORTS];
  for (unsigned p = 0; p < RS_PORTS; ++p) {
    id[p] = neighbour[p].up ? neighbour[p].id : RS_ID_NONE;
    port[p] = id[p] == RS_ID_NONE ? 0U : (neighbour[p].port - 1U) & 3U;
  }
  const rs_topology topology = {.type = RS_TYPE_topology,
                                .source = cell->id,
                                .uid = cell->uid,
                                .revision = cell->topology_revision,
                                .parent_port = cell->route.parent_port,
                                .ttl = RS_TTL_START,
                                .closed = rs_tags_told(cell),
                                .neighbour_1 = id[0],
                                .neighbour_port_1 = port[0],
                                .errors_1 = binary_digits(neighbour[0].lost),
                                .neighbour_2 = id[1],
                                .neighbour_port_2 = port[1],
                                .errors_2 = binary_digits(neighbour[1].lost),
                                .neighbour_3 = id[2],
                                .neighbour_port_3 = port[2],
                                .errors_3 = binary_digits(neighbour[2].lost),
                                .neighbour_4 = id[3],
                                .neighbour_port_4 = port[3],
                                .errors_4 = binary_digits(neighbour[3].lost)};
  RS_WORDS uint8_t frame[RS_FRAME_BYTES];
  rs_topology_pack(frame, &topology);
  rs_frame_seal(frame);
  rs_queue_up(cell, frame, now_us);
}

static void ask_for_id(rs_cell* cell, uint32_t now_us) {
  const rs_join join = {.type = RS_TYPE_join,
                        .uid = cell->uid,
                        .ttl = RS_TTL_START,
                        .nonce = cell->nonce,
                        .wanted = cell->settings.id,
                        .challenge = cell->challenge};
  RS_WORDS uint8_t frame[RS_FRAME_BYTES];
  rs_join_pack(frame, &join);
  rs_frame_seal(frame);
  rs_queue_up(cell, frame, now_us);
}

void rs_identity_check(rs_cell* cell, uint32_t now_us) {
  if (cell->route.parent_port == RS_NO_PARENT) {
    /* All cells of a tree find their way within a millisecond or two; they do not all ask at once. */
    cell->join_us = now_us + rs_spread(cell->uid) % RS_JOIN_SPREAD_US;
    return;
  }
  if (cell->id == RS_ID_NONE) {
    if (rs_reached(now_us, cell->join_us) || cell->join_us - now_us > RS_JOIN_US) {
      cell->join_us = now_us + RS_JOIN_US;
      ask_for_id(cell, now_us);
    }
  } else if (rs_reached(now_us, cell->topology_us) || cell->topology_us - now_us > RS_TOPOLOGY_US) {
    cell->topology_us = now_us + RS_TOPOLOGY_US - rs_spread(cell->uid + now_us) % RS_TOPOLOGY_EARLY_US;
    report_topology(cell, now_us);
  }
}
