/* SPDX-License-Identifier: Apache-2.0
 * What a cell must know to compute the torques that touch on it means, and the image of it in the cell's flash. */
#ifndef ROBOTSKIN_TORQUE_PARAMETERS_H
#define ROBOTSKIN_TORQUE_PARAMETERS_H

#include <stdbool.h>
#include <stdint.h>

#include "robotskin/chain.h"
#include "robotskin/touch.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The image, numbers big-endian: version 1, limb 1, joints 1, length exponent 1, step bits 1, zero 1, prismatic 2,
 * slide 2, point 3 x 2, direction 3 x 2, force (silent, full, weight) 3 x 2, force weight bits 1, proximity weight
 * bits 1, proximity (silent, full, weight) 3 x 2, places 11 x (rotation 9 x 2, offset 3 x 2), checksum 2, 4 of no
 * meaning. What differs between the cells of a link stands in three words. The checksum covers everything up to the
 * last place that the chain has; what stands behind that has no meaning. */
enum {
  RS_TORQUE_WORD_BYTES = 6, /* written by one command */
  RS_TORQUE_WORDS = 51,
  RS_TORQUE_IMAGE_BYTES = RS_TORQUE_WORDS * RS_TORQUE_WORD_BYTES,
  RS_TORQUE_PLACES_AT = 36,
  RS_TORQUE_PLACE_BYTES = 24,
  RS_TORQUE_CHECKSUM_AT = RS_TORQUE_PLACES_AT + (RS_CHAIN_JOINTS - 1) * RS_TORQUE_PLACE_BYTES,
  RS_TORQUE_LIMBS = 16,
  RS_TORQUE_STEP_BITS = 8 /* usual: a step of 0.0039 Nm, sums up to 128 Nm */
};

/* Of two-byte members and pairs of bytes alone, so that equal parameters are equal in every byte. */
typedef struct {
  rs_chain chain;
  rs_touch_gains gains;
  uint16_t slide;    /* longest way of a sliding joint from its zero, m, RS_LENGTH_BITS */
  uint8_t limb;      /* 0 to 15 */
  uint8_t step_bits; /* one step of the limb's sums is 2^-step_bits Nm (or N); at most RS_TORQUE_BITS - 1 */
} rs_torque_parameters;

void rs_torque_parameters_pack(const rs_torque_parameters* parameters, uint8_t image[RS_TORQUE_IMAGE_BYTES]);

/* Bytes of an image that have a meaning and stand before the checksum. */
uint32_t rs_torque_parameters_bytes(const uint8_t image[RS_TORQUE_IMAGE_BYTES]);

/* The checksum that an image must have. */
uint16_t rs_torque_parameters_checksum(const uint8_t image[RS_TORQUE_IMAGE_BYTES]);

/* Reads an image; false, and no joints, if its version, checksum or chain is not right. */
bool rs_torque_parameters_unpack(rs_torque_parameters* parameters, const uint8_t image[RS_TORQUE_IMAGE_BYTES]);

#ifdef __cplusplus
}
#endif

#endif
