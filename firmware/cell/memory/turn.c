/* SPDX-License-Identifier: Apache-2.0
 * Turns: a cell learns which it is with its name, under its own key and challenge, and counts on from there. */
#include "cell/memory/turn.h"

#include "cell/memory/integrity.h"
#include "cell/memory/known_time.h"

void rs_turn_take(rs_cell* cell, uint32_t turn) {
  cell->turn = turn & RS_TURN_MASK;
  rs_key_of_turn(cell->keys, cell->turn, cell->turn_key);
  rs_cell_seal(cell);
}

void rs_turn_follow(rs_cell* cell, uint32_t time) {
  const rs_route* route = &cell->route;
  if (cell->turn == RS_TURN_NONE || !rs_time_known(route)) return;
  if (time < route->known_time && route->known_time - time > RS_TICK_TIME_HALF) {
    rs_turn_take(cell, cell->turn + 1U);
  }
}
