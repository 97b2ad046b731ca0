/* SPDX-License-Identifier: Apache-2.0
 * The ids of the cells of a unit: given once, kept by serial number, taken back when two cells claim one. */
#include "section_unit/id_allocator.h"

#include <stddef.h>
#include <string.h>

#include "cell/time/spread.h"

enum { NAMES_MASK = 2 * RS_UNIT_NAMES_MAX - 1 };

void rs_ids_init(rs_unit_ids* ids, const rs_section_unit_config* config) {
  memset(ids, 0, sizeof *ids);
  /* After a restart the ids of running cells are not known yet: starting anywhere, a new cell seldom meets one. */
  const uint32_t range = (uint32_t)config->last_id - config->first_id + 1U;
  ids->next_id = (uint16_t)(config->first_id + rs_spread(config->session) % range);
}

/* The entry of a cell, made if it is new; NULL if the table is full. */
static rs_unit_name* entry_of(rs_unit_ids* ids, uint32_t uid) {
  uint32_t at = rs_spread(uid) & NAMES_MASK;
  while (ids->entry[at].uid != 0U && ids->entry[at].uid != uid) at = (at + 1U) & NAMES_MASK;
  rs_unit_name* entry = &ids->entry[at];
  if (entry->uid == 0U) {
    if (ids->count >= RS_UNIT_NAMES_MAX) return NULL;
    ++ids->count;
    entry->uid = uid;
  }
  return entry;
}

static bool is_taken(const rs_unit_ids* ids, uint32_t id) {
  return (ids->taken[id / 8U] >> (id % 8U) & 1U) != 0U;
}

static void give(rs_unit_ids* ids, rs_unit_name* entry, uint16_t id) {
  if (entry->id != RS_ID_NONE) ids->taken[entry->id / 8U] &= (uint8_t)~(1U << (entry->id % 8U));
  entry->id = id;
  ids->uid_of[id] = entry->uid;
  if (id != RS_ID_NONE) ids->taken[id / 8U] |= (uint8_t)(1U << (id % 8U));
}

static bool is_ours(const rs_section_unit_config* config, uint16_t id) {
  return id >= config->first_id && id <= config->last_id;
}

uint16_t rs_ids_give(rs_unit_ids* ids, const rs_section_unit_config* config, uint32_t uid, uint16_t wanted) {
  rs_unit_name* entry = uid == 0U ? NULL : entry_of(ids, uid);
  if (entry != NULL && entry->id != RS_ID_NONE) return entry->id;
  if (entry != NULL && is_ours(config, wanted) && !is_taken(ids, wanted)) {
    give(ids, entry, wanted);
    return wanted;
  }
  const uint32_t range = (uint32_t)config->last_id - config->first_id + 1U;
  for (uint32_t tried = 0; entry != NULL && tried < range; ++tried) {
    const uint16_t id = ids->next_id;
    ids->next_id = id == config->last_id ? config->first_id : (uint16_t)(id + 1U);
    if (is_taken(ids, id)) continue;
    give(ids, entry, id);
    return id;
  }
  ++ids->refused;
  return RS_ID_NONE;
}

bool rs_ids_agree(rs_unit_ids* ids, const rs_section_unit_config* config, uint32_t uid, uint16_t id) {
  rs_unit_name* entry = uid == 0U ? NULL : entry_of(ids, uid);
  if (entry == NULL || entry->id == id) return true;
  if (!is_ours(config, id)) {
    give(ids, entry, RS_ID_NONE); /* another unit of the group has named it */
    if (id <= RS_ID_LAST) ids->uid_of[id] = uid;
    return true;
  }
  if (is_taken(ids, id)) return false;
  give(ids, entry, id);
  return true;
}
