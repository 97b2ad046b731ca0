/* SPDX-License-Identifier: Apache-2.0
 * Numbers of a processor without a floating-point unit: 32-bit integers, a fixed number of whose bits are a fraction.
 *
 * A product of two is rounded to the nearest, halves upwards, when its surplus bits are dropped. The right shift of a
 * negative number keeps its sign on every compiler this firmware is built with; a test demands it. */
#ifndef ROBOTSKIN_FIXED_POINT_H
#define ROBOTSKIN_FIXED_POINT_H

#include <stdint.h>

#include "robotskin/portable.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
  RS_UNIT_BITS = 15,   /* sines and directions: 1 is 32768 */
  RS_MATRIX_BITS = 14, /* elements of stored rotation matrices, which must hold 1 in 16 bits: 1 is 16384 */
  RS_LENGTH_BITS = 15, /* lengths: a chain's unit of length is 32768 */
  RS_FORCE_BITS = 12,  /* newton: 1 is 4096 */
  RS_TORQUE_BITS = 16, /* newton metres within a cell: 1 is 65536 */
  RS_TURN = 65536,     /* angles: one turn */
  RS_QUARTER_TURN = RS_TURN / 4
};

/* value / 2^bits, rounded; 1 to 30 bits, and |value| at most 2^31 - 2^(bits - 1) - 1. */
RS_INLINE int32_t rs_shifted(int32_t value, unsigned bits) {
  return (value + ((int32_t)1 << (bits - 1U))) >> bits;
}

/* The nearest value within -limit to limit. */
RS_INLINE int32_t rs_saturated(int32_t value, int32_t limit) {
  return value > limit ? limit : value < -limit ? -limit : value;
}

/* Sine of an angle in 2 pi / 65536 rad, of which the low 16 bits count, with RS_UNIT_BITS; within 1e-4 of the true one.
 *
 * A quarter of the wave by the odd polynomial of fifth order with the smallest greatest error, 6.8e-5 (Bergner et al.
 * 2018 use one of that order; the coefficients are by Remez exchange); the rest is rounding. */
int32_t rs_sine(int32_t angle);

RS_INLINE int32_t rs_cosine(int32_t angle) {
  return rs_sine(angle + RS_QUARTER_TURN);
}

#ifdef __cplusplus
}
#endif

#endif
