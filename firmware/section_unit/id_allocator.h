/* SPDX-License-Identifier: Apache-2.0
 * The ids of the cells of a unit. */
#ifndef ROBOTSKIN_SECTION_UNIT_ID_ALLOCATOR_H
#define ROBOTSKIN_SECTION_UNIT_ID_ALLOCATOR_H

#include "robotskin/section_unit.h"

void rs_ids_init(rs_unit_ids* ids, const rs_section_unit_config* config);
/* The id for a cell that asks and would like `wanted`; RS_ID_NONE if there is none left. */
uint16_t rs_ids_give(rs_unit_ids* ids, const rs_section_unit_config* config, uint32_t uid, uint16_t wanted);
/* Takes note of a named cell; false if its id belongs to another, so that it has to ask anew. */
bool rs_ids_agree(rs_unit_ids* ids, const rs_section_unit_config* config, uint32_t uid, uint16_t id);

#endif
