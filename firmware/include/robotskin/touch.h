/* SPDX-License-Identifier: Apache-2.0
 * From what a cell senses to the force it asks for along its -z [Cheng19 eq. 14], with smooth activation.
 */
#ifndef ROBOTSKIN_TOUCH_H
#define ROBOTSKIN_TOUCH_H

#include <stdint.h>

#include "robotskin/channels.h"
#include "robotskin/fixed_point.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One of the two senses. Below `silent` it contributes nothing, from `full` on all of it, between them a share x^2
 * (3 - 2 x) of it, which grows without a step or a kink. */
typedef struct {
  uint16_t silent; /* counts */
  uint16_t full;   /* counts, greater than `silent` */
  uint16_t weight; /* newton asked for, a count: weight / 2^weight_bits */
  uint8_t weight_bits;
  uint8_t none; /* named, so that equal senses are equal in every byte */
} rs_sense;

typedef struct {
  rs_sense force; /* of the sum of the three sensors */
  rs_sense proximity;
} rs_touch_gains;

enum {
  RS_TOUCH_FORCE_COUNTS = 3 * 1023, /* the three sensors at the ends of their ranges */
  RS_TOUCH_FORCE_LIMIT = 32767 << RS_FORCE_BITS
};

/* Newton with RS_FORCE_BITS, 0 to RS_TOUCH_FORCE_LIMIT; 0 for gains out of order. */
int32_t rs_touch_force(const rs_touch_gains* gains, const rs_sample* sample);

#ifdef __cplusplus
}
#endif

#endif
