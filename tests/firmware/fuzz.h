/* SPDX-License-Identifier: Apache-2.0
 * What the parts of the firmware's fuzzer share: chance, demands and hostile frames. */
#ifndef ROBOTSKIN_FUZZ_H
#define ROBOTSKIN_FUZZ_H

#include <stdbool.h>
#include <stdint.h>

#include "robotskin/cell.h"
#include "robotskin/wire.h"

void seed_chance(uint64_t seed);
uint32_t draw(void);
/* Says what is broken, and aborts. */
void require(bool holds, const char* what);
/* Random bytes, with a right checksum most of the time, and often a plausible tick or command. */
void hostile_frame(uint8_t frame[RS_FRAME_BYTES], uint16_t sequence, const rs_cell* cell);

void fuzz_cell(uint32_t steps, bool keyed);
/* Memory that is damaged anywhere: nothing undefined is done with it, and the tree state heals. */
void fuzz_damage(uint32_t steps);
void fuzz_unit(uint32_t steps, bool keyed);
void fuzz_receiver(uint32_t steps);
/* Two cells hear the same; one of them never finds itself calm, and so goes the long way. */
void fuzz_ways(uint32_t steps);

#endif
