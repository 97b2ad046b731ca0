/* SPDX-License-Identifier: Apache-2.0
 * The torques of a force at a point on the joints below it, in whole numbers. */
#include "robotskin/chain.h"

/* A bound of a vector's length: the largest component and half of the others, since (a^2 + b^2)^(1/2) <= a + b^2 / 2a.
 */
static int32_t length_at_most(const int16_t vector[3]) {
  int32_t largest = 0, sum = 0;
  for (unsigned i = 0; i < 3U; ++i) {
    const int32_t size = vector[i] < 0 ? -(int32_t)vector[i] : vector[i];
    sum += size;
    if (size > largest) largest = size;
  }
  return largest + (sum - largest) / 2 + 1;
}

enum { ROUNDED = 8 }; /* by which rounding may make a unit vector longer */

static bool unit_at_most(const int16_t vector[3], int32_t one) {
  const int32_t limit = one + ROUNDED;
  uint32_t square = 0;
  for (unsigned i = 0; i < 3U; ++i) {
    if (vector[i] > limit || vector[i] < -limit) return false;
    square += (uint32_t)((int32_t)vector[i] * vector[i]);
  }
  return square <= (uint32_t)(limit * limit);
}

static bool turns_only(const rs_chain* chain) {
  if (!unit_at_most(chain->direction, 1 << RS_UNIT_BITS)) return false;
  for (unsigned l = 0; l + 1U < chain->joints; ++l) {
    for (unsigned row = 0; row < 9U; row += 3U) {
      if (!unit_at_most(chain->place[l].rotation + row, 1 << RS_MATRIX_BITS)) return false;
    }
  }
  return true;
}

bool rs_chain_valid(const rs_chain* chain, int32_t slide) {
  if (chain->joints < 1U || chain->joints > RS_CHAIN_JOINTS || chain->length_exponent < RS_LENGTH_EXPONENT_MIN ||
      chain->length_exponent > RS_LENGTH_EXPONENT_MAX || slide < 0 || !turns_only(chain)) {
    return false;
  }
  int32_t reach = length_at_most(chain->point);
  for (unsigned l = chain->joints; l-- > 0U;) {
    if ((chain->prismatic >> l & 1U) != 0U) reach += slide;
    if (reach > RS_CHAIN_REACH) return false;
    if (l > 0U) reach += length_at_most(chain->place[l - 1U].offset);
  }
  return true;
}

/* A vector in the frame of the joint before, without the offset; `sine` and `cosine` turn it by the joint's position.
 */
static void lower(int32_t vector[3], const int16_t rotation[9], int32_t sine, int32_t cosine) {
  const int32_t x = rs_shifted(cosine * vector[0] - sine * vector[1], RS_UNIT_BITS);
  const int32_t y = rs_shifted(sine * vector[0] + cosine * vector[1], RS_UNIT_BITS);
  const int32_t z = vector[2];
  for (unsigned i = 0; i < 3U; ++i, rotation += 3) {
    vector[i] = rs_shifted(rotation[0] * x + rotation[1] * y + rotation[2] * z, RS_MATRIX_BITS);
  }
}

/* force * lever in Nm with RS_TORQUE_BITS. The force is brought to 15 bits first, so that small ones stay exact. */
static int32_t torque_of(int32_t force, unsigned force_shift, int32_t lever, int length_exponent, bool* saturated) {
  const int32_t product = (force >> force_shift) * lever; /* RS_FORCE_BITS - force_shift + RS_LENGTH_BITS */
  const int drop = RS_FORCE_BITS + RS_LENGTH_BITS - RS_TORQUE_BITS - length_exponent - (int)force_shift;
  if (drop > 0) return rs_shifted(product, (unsigned)drop);
  const int32_t limit = INT32_MAX >> -drop;
  if (product > limit || product < -limit) *saturated = true;
  return rs_saturated(product, limit) * ((int32_t)1 << -drop);
}

bool rs_chain_torque(const rs_chain* chain, const int16_t* position, int32_t force, int32_t* torque) {
  int32_t point[3], direction[3];
  for (unsigned i = 0; i < 3U; ++i) {
    point[i] = chain->point[i];
    direction[i] = chain->direction[i];
  }
  unsigned force_shift = 0;
  while ((force >> force_shift) > INT16_MAX) ++force_shift;
  bool saturated = false;
  for (unsigned l = chain->joints; l-- > 0U;) {
    int32_t sine = 0, cosine = (int32_t)1 << RS_UNIT_BITS;
    if ((chain->prismatic >> l & 1U) != 0U) {
      torque[l] = torque_of(force, force_shift, direction[2], 0, &saturated);
      point[2] += chain->length_exponent > 0 ? rs_shifted(position[l], (unsigned)chain->length_exponent)
                                             : position[l] * ((int32_t)1 << -chain->length_exponent);
    } else {
      /* [Cheng19 eq. 16] of one joint: the lever of the force about its axis, times the force */
      const int32_t lever = rs_shifted(point[0] * direction[1] - point[1] * direction[0], RS_UNIT_BITS);
      torque[l] = torque_of(force, force_shift, lever, chain->length_exponent, &saturated);
      sine = rs_sine(position[l]);
      cosine = rs_cosine(position[l]);
    }
    if (l == 0U) break;
    const rs_chain_place* place = &chain->place[l - 1U];
    lower(point, place->rotation, sine, cosine);
    lower(direction, place->rotation, sine, cosine);
    for (unsigned i = 0; i < 3U; ++i) point[i] += place->offset[i]; /* [Cheng19 eq. 21] */
  }
  return !saturated;
}
