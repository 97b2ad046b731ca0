/* SPDX-License-Identifier: Apache-2.0
 * The budget of wrong tags: a count by place that falls by one a second and, once it is spent, stands so high that it
 * takes RS_TAGS_CLOSED_S to open again and RS_TAGS_TOLD_S more until the budget is back at all. So whatever comes, no
 * more than RS_TAGS_BUDGET wrong tags, and one a second, are read at a place. */
#include "cell/routing/wrong_tags.h"

enum { OPEN_MOST = RS_TAGS_BUDGET + RS_TAGS_TOLD_S, SPENT = OPEN_MOST + RS_TAGS_CLOSED_S };

/* Damaged memory must close nothing. */
static unsigned wrong_tags(const rs_cell* cell, unsigned place) {
  const unsigned count = cell->wrong_tags[place];
  return (count ^ cell->wrong_tags_complement[place]) == 0xFFU && count <= SPENT ? count : 0U;
}

static void set(rs_cell* cell, unsigned place, unsigned count) {
  cell->wrong_tags[place] = (uint8_t)count;
  cell->wrong_tags_complement[place] = (uint8_t)~count;
}

bool rs_tags_closed(const rs_cell* cell, unsigned place) {
  return wrong_tags(cell, place) > OPEN_MOST;
}

unsigned rs_tags_told(const rs_cell* cell) {
  for (unsigned place = 0; place < RS_TAG_PLACES; ++place) {
    if (wrong_tags(cell, place) > RS_TAGS_BUDGET) return place + 1U;
  }
  return 0;
}

bool rs_tags_spend(rs_cell* cell, unsigned place) {
  const unsigned count = wrong_tags(cell, place) + 1U;
  const bool spent = count > RS_TAGS_BUDGET;
  ++cell->counts.tags_refused;
  set(cell, place, spent ? SPENT : count);
  return spent;
}

void rs_tags_forgive(rs_cell* cell, uint32_t now_us) {
  if (now_us - cell->forgiven_us < RS_TAG_FORGIVEN_US) return;
  cell->forgiven_us = now_us;
  for (unsigned place = 0; place < RS_TAG_PLACES; ++place) {
    const unsigned count = wrong_tags(cell, place);
    set(cell, place, count == 0U ? 0U : count - 1U);
  }
}
