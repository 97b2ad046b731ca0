/* SPDX-License-Identifier: Apache-2.0
 * Sine and cosine in whole numbers. */
#include "robotskin/fixed_point.h"

/* sin(pi/2 u) = c1 u + c3 u^3 + c5 u^5 for u in 0 to 1, with 16 fraction bits: the neighbours of the best coefficients
 * whose greatest error, all roundings included, is the smallest. */
enum { COEFFICIENT_BITS = 16, C1 = 102912, C3 = -42078, C5 = 4706 };

int32_t rs_sine(int32_t angle) {
  int32_t folded = (int32_t)((uint32_t)angle & (RS_TURN - 1U));
  const int negative = folded >= RS_TURN / 2;
  if (negative) folded -= RS_TURN / 2;
  if (folded > RS_QUARTER_TURN) folded = RS_TURN / 2 - folded;
  const int32_t u = 2 * folded; /* RS_UNIT_BITS */
  const int32_t square = rs_shifted(u * u, RS_UNIT_BITS);
  int32_t sum = rs_shifted(C5 * square, RS_UNIT_BITS) + C3;
  sum = rs_shifted(sum * square, RS_UNIT_BITS) + C1;
  const int32_t sine = (int32_t)(((uint32_t)sum * (uint32_t)u + (1U << (COEFFICIENT_BITS - 1))) >> COEFFICIENT_BITS);
  return negative ? -sine : sine;
}
