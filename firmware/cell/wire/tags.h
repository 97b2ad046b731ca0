/* SPDX-License-Identifier: Apache-2.0
 * Tags of the frames that only a section unit may make. */
#ifndef ROBOTSKIN_CELL_WIRE_TAGS_H
#define ROBOTSKIN_CELL_WIRE_TAGS_H

#include "robotskin/cell.h"

uint32_t rs_wave_tag(const rs_chaskey_key* key, const rs_wave* wave);
/* The tag of a joints frame of an epoch, whose number the frame tells modulo 64. */
uint32_t rs_joints_tag(const uint8_t key[RS_CELL_KEY_BYTES], const uint8_t frame[RS_FRAME_BYTES], uint32_t epoch);
/* The tag of a command or grant frame sent at a tick time, of which it covers the second (1024 ticks). */
enum { RS_TAG_SECOND_BITS = 10 };
uint32_t rs_command_tag(const uint8_t key[RS_CELL_KEY_BYTES], const uint8_t frame[RS_FRAME_BYTES], uint32_t time);

#endif
