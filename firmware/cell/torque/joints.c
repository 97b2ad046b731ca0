/* SPDX-License-Identifier: Apache-2.0
 * Joint positions, broadcast down the tree once an epoch: passed on, and those of the own limb kept. */
#include "cell/torque/joints.h"

#include "cell/memory/known_time.h"
#include "cell/routing/refusal.h"
#include "cell/time/tick_time.h"
#include "cell/transport/queues.h"
#include "cell/wire/tags.h"
#include "cell/wire/wave.h"

enum { TICK_TIME_MASK = (1 << RS_TICK_TIME_BITS) - 1, EPOCHS_OLD = 16 };

/* The epoch whose low bits a frame has: the last such one up to the next, as a cell's time may be a little behind. */
static uint32_t epoch_of(uint32_t low, uint32_t now) {
  return now + 1U - ((now + 1U - low) & RS_EPOCH_MASK);
}

void rs_joints_receive(rs_cell* cell, unsigned port, const uint8_t* frame, uint32_t now_us) {
  rs_joints_state* state = &cell->joints;
  rs_joints joints;
  rs_joints_unpack(&joints, frame);
  const uint32_t now = rs_tick_time(cell, now_us) / RS_EPOCH_TICKS;
  const uint32_t epoch = epoch_of(joints.epoch, now);
  if (cell->keyed && cell->turn == RS_TURN_NONE) return; /* it cannot tell yet */
  if (now + 1U - epoch > EPOCHS_OLD) {
    ++cell->counts.tags_refused;
    return;
  }
  if (cell->keyed && !rs_tags_equal(rs_joints_tag(cell->turn_key, frame, epoch), joints.tag)) {
    rs_refuse_tag(cell, port, now_us);
    return;
  }
  /* The own time may have gone back, to that of ticks that are played again: these joints are then, too. */
  const uint32_t time = epoch * RS_EPOCH_TICKS;
  const bool timed = state->latest == ~state->latest_complement;
  const bool before = timed && rs_time_went_back(rs_ticks_between(state->latest, time));
  if (before && rs_ticks_between(time, state->latest) >= EPOCHS_OLD * RS_EPOCH_TICKS) {
    ++cell->counts.commands_stale;
    return;
  }
  uint8_t* newest = &state->newest[joints.limb][joints.part];
  if (state->known[joints.limb] >> joints.part & 1U && (uint8_t)(*newest - epoch) < EPOCHS_OLD) {
    ++cell->counts.commands_stale;
    return;
  }
  *newest = (uint8_t)epoch;
  if (!before) {
    state->latest = time;
    state->latest_complement = ~state->latest;
  }
  state->known[joints.limb] |= (uint8_t)(1U << joints.part);
  rs_queue_down(cell, frame);
  if (joints.limb != cell->torque.own.limb || joints.part >= RS_TORQUE_PARTS) return;
  if (state->limb != joints.limb) {
    state->limb = (uint8_t)joints.limb;
    state->received_mask = 0;
  }
  state->received_mask |= (uint8_t)(1U << joints.part);
  const int32_t position[RS_JOINTS_PER_PART] = {joints.joint_1, joints.joint_2, joints.joint_3,
                                                joints.joint_4, joints.joint_5, joints.joint_6};
  for (unsigned i = 0; i < RS_JOINTS_PER_PART; ++i) {
    state->position[RS_JOINTS_PER_PART * joints.part + i] = (int16_t)position[i];
  }
  state->epoch[joints.part] = epoch & (TICK_TIME_MASK / RS_EPOCH_TICKS);
}
