/* SPDX-License-Identifier: Apache-2.0
 * The force that touch asks for. */
#include "robotskin/touch.h"

/* `counts` times its share of activation times the weight, newton with RS_FORCE_BITS. */
static int32_t asked(const rs_sense* sense, int32_t counts) {
  if (sense->full <= sense->silent || counts <= (int32_t)sense->silent || sense->weight_bits > 30U) return 0;
  uint32_t share = (uint32_t)1 << RS_UNIT_BITS;
  if (counts < (int32_t)sense->full) {
    const uint32_t x = ((uint32_t)(counts - sense->silent) << RS_UNIT_BITS) / (uint32_t)(sense->full - sense->silent);
    share = ((x * x) >> RS_UNIT_BITS) * (3U * ((uint32_t)1 << RS_UNIT_BITS) - 2U * x) >> RS_UNIT_BITS;
  }
  /* Counts with RS_UNIT_BITS, brought to 16 bits, so that small touches stay exact and the product fits. */
  uint32_t active = (uint32_t)counts * share;
  int bits = RS_UNIT_BITS;
  for (; active > UINT16_MAX; --bits) active >>= 1;
  const uint32_t newton = active * sense->weight;
  const int drop = bits + sense->weight_bits - RS_FORCE_BITS;
  if (drop >= 32) return 0;
  if (drop >= 0) return newton >> drop > RS_TOUCH_FORCE_LIMIT ? RS_TOUCH_FORCE_LIMIT : (int32_t)(newton >> drop);
  return newton > ((uint32_t)RS_TOUCH_FORCE_LIMIT >> -drop) ? RS_TOUCH_FORCE_LIMIT : (int32_t)(newton << -drop);
}

int32_t rs_touch_force(const rs_touch_gains* gains, const rs_sample* sample) {
  int32_t felt = 0;
  for (int channel = RS_CHANNEL_force_1; channel <= RS_CHANNEL_force_3; ++channel) {
    felt += sample->value[channel] > 0 ? sample->value[channel] : 0;
  }
  if (felt > RS_TOUCH_FORCE_COUNTS) felt = RS_TOUCH_FORCE_COUNTS;
  int32_t near = sample->value[RS_CHANNEL_proximity];
  near = near < 0 ? 0 : near > UINT16_MAX ? UINT16_MAX : near;
  /* [Cheng19 eq. 14] */
  return rs_saturated(asked(&gains->force, felt) + asked(&gains->proximity, near), RS_TOUCH_FORCE_LIMIT);
}
