/* SPDX-License-Identifier: Apache-2.0
 * Sums of torques, within what their frames can carry. */
#include "robotskin/torque.h"

static uint32_t at_most(uint32_t value, uint32_t limit) {
  return value < limit ? value : limit;
}

static int32_t clamped(int32_t value, bool* saturated) {
  if (value > INT16_MAX) return *saturated = true, INT16_MAX;
  if (value < INT16_MIN) return *saturated = true, INT16_MIN;
  return value;
}

void rs_torque_sum_start(rs_torque_sum* sum, uint32_t limb, uint32_t part) {
  *sum = (rs_torque_sum){.limb = (uint8_t)limb, .part = (uint8_t)part};
}

void rs_torque_sum_add(rs_torque_sum* sum, const rs_torque* torque) {
  /* Each addend has 16 bits, so 65535 of them do not wrap; what damaged memory holds may, and is wrong anyway. */
  const int32_t joint[RS_JOINTS_PER_PART] = {torque->joint_1, torque->joint_2, torque->joint_3,
                                             torque->joint_4, torque->joint_5, torque->joint_6};
  for (unsigned i = 0; i < RS_JOINTS_PER_PART; ++i) /* [Cheng19 eq. 17] */
    sum->joint[i] = (int32_t)((uint32_t)sum->joint[i] + (uint32_t)joint[i]);
  sum->cells = (uint16_t)at_most((uint32_t)sum->cells + torque->cells, RS_FIELD_MAX(torque_cells));
  sum->active = (uint16_t)at_most((uint32_t)sum->active + torque->active, RS_FIELD_MAX(torque_active));
  if (torque->age > sum->age) sum->age = (uint8_t)torque->age;
  sum->saturated = sum->saturated || torque->saturated != 0U;
}

void rs_torque_sum_frame(const rs_torque_sum* sum, uint32_t epoch, bool last, rs_torque* torque) {
  bool saturated = sum->saturated;
  *torque = (rs_torque){.type = RS_TYPE_torque,
                        .epoch = epoch & RS_EPOCH_MASK,
                        .limb = sum->limb,
                        .part = sum->part,
                        .joint_1 = clamped(sum->joint[0], &saturated),
                        .joint_2 = clamped(sum->joint[1], &saturated),
                        .joint_3 = clamped(sum->joint[2], &saturated),
                        .joint_4 = clamped(sum->joint[3], &saturated),
                        .joint_5 = clamped(sum->joint[4], &saturated),
                        .joint_6 = clamped(sum->joint[5], &saturated),
                        .cells = at_most(sum->cells, RS_FIELD_MAX(torque_cells)),
                        .active = at_most(sum->active, RS_FIELD_MAX(torque_active)),
                        .age = at_most(sum->age, RS_FIELD_MAX(torque_age)),
                        .last = last};
  torque->saturated = saturated;
}
