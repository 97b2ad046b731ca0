/* SPDX-License-Identifier: Apache-2.0
 * The joints below a cell, as the cell keeps them, and the joint torques that a force on the cell means.
 *
 * Frames: joint l of a chain of n (l = 0 nearest the base) turns about, or slides along, the z axis of its frame; the
 * frame's place at position 0 in the frame of joint l - 1 is constant. Lengths count in a unit
 * of the chain's own, 2^length_exponent metres, so that a hand is as exact as an arm. */
#ifndef ROBOTSKIN_CHAIN_H
#define ROBOTSKIN_CHAIN_H

#include <stdbool.h>
#include <stdint.h>

#include "robotskin/fixed_point.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
  RS_CHAIN_JOINTS = 12,
  /* The longest way from a joint to the cell, in units: with it no product leaves 32 bits. */
  RS_CHAIN_REACH = 9 * (1 << RS_LENGTH_BITS) / 5,
  RS_LENGTH_EXPONENT_MIN = -8,
  RS_LENGTH_EXPONENT_MAX = 3
};

/* Where a joint at position 0 is in the frame of the joint before it. */
typedef struct {
  int16_t rotation[9]; /* row by row, RS_MATRIX_BITS */
  int16_t offset[3];   /* of its origin, units, RS_LENGTH_BITS */
} rs_chain_place;

typedef struct {
  rs_chain_place place[RS_CHAIN_JOINTS - 1]; /* of joint l + 1; where joint 0 is in the base is of no consequence */
  uint16_t prismatic;                        /* bit l: joint l slides */
  uint8_t joints;                            /* 1 to 12; 0: none known, the cell contributes nothing */
  int8_t length_exponent;                    /* one unit is 2^length_exponent m */
  int16_t point[3];                          /* of the cell in the last joint's frame, units, RS_LENGTH_BITS */
  int16_t direction[3];                      /* in which touch acts there, the cell's -z, RS_UNIT_BITS, 32767 for 1 */
} rs_chain;

/* Whether a chain may be used: counts and exponent in range, rotations no longer than 1, and no posture in which a way
 * from a joint to the cell is longer than RS_CHAIN_REACH. A prismatic joint counts with `slide`, its longest way in
 * units, RS_LENGTH_BITS. */
bool rs_chain_valid(const rs_chain* chain, int32_t slide);

/* torque[l], Nm with RS_TORQUE_BITS, or N for a joint that slides, by a force of `force` N (RS_FORCE_BITS, not
 * negative) on the cell, for l below chain->joints. `position[l]`: 2 pi / 65536 rad, or m with RS_LENGTH_BITS.
 *
 * [Cheng19 eq. 16] by the projections p = t_cell - t_joint of [Cheng19 eq. 21]: each is held in its joint's own frame,
 * from the last joint to the first, so that the joint's axis is z and no rotation matrix is ever multiplied with
 * another: torque = (p x d)_z |F|. Returns false if a torque was beyond its 32 bits and is held at the end. */
bool rs_chain_torque(const rs_chain* chain, const int16_t* position, int32_t force, int32_t* torque);

#ifdef __cplusplus
}
#endif

#endif
