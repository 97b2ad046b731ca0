/* SPDX-License-Identifier: Apache-2.0
 * A step the long way: whatever comes, and whatever is due. */
#include "cell/slow_path.h"

#include <stddef.h>
#include <string.h>

#include "cell/commands.h"
#include "cell/link/link.h"
#include "cell/memory/integrity.h"
#include "cell/routing/beacons.h"
#include "cell/routing/identity.h"
#include "cell/routing/links.h"
#include "cell/routing/moves.h"
#include "cell/routing/parent.h"
#include "cell/routing/route.h"
#include "cell/routing/subtree.h"
#include "cell/routing/wrong_tags.h"
#include "cell/sampling.h"
#include "cell/time/clock.h"
#include "cell/time/sample_clock.h"
#include "cell/time/timer.h"
#include "cell/torque/cell_torque.h"
#include "cell/torque/joints.h"
#include "cell/torque/torque_epoch.h"
#include "cell/transmit.h"
#include "cell/transport/arq_sender.h"
#include "cell/transport/parent_change.h"
#include "cell/transport/queues.h"
#include "robotskin/crc.h"

static RS_NOINLINE void check(rs_cell* cell, uint32_t now_us) {
  rs_queues_check(cell, now_us);
  rs_arq_sender_check(cell, now_us);
  rs_torque_check(cell);
  rs_cell_heal_settings(cell, now_us);
  rs_sampling_check(cell, now_us);
  rs_route_check(cell, now_us);
  rs_tags_forgive(cell, now_us);
  rs_identity_check(cell, now_us);
  if (cell->route.parent_port != RS_NO_PARENT && now_us - cell->route.reported_us >= RS_STATUS_US) {
    cell->queues.status_due = true;
  }
  rs_timer_set(cell, now_us);
}

static RS_NOINLINE void boot(rs_cell* cell, const rs_boot* with, uint32_t now_us) {
  memset(cell, 0, sizeof *cell);
  cell->uid = with->uid;
  cell->step_us = with->step_us;
  rs_settings_load(&cell->settings, with->flash);
  rs_cell_keep_settings(cell);
  cell->led_complement = ~cell->led_rgb;
  if (with->flash != NULL) memcpy(cell->flash, with->flash, RS_FLASH_BYTES);
  rs_cell_torque_load(cell);
  cell->turn = RS_TURN_NONE;
  cell->keyed = with->keys != NULL;
  if (cell->keyed) {
    rs_chaskey_key_expand(&cell->key, with->keys);
    memcpy(cell->keys, with->keys, RS_CELL_KEYS_BYTES);
  }
  rs_identity_boot(cell, with->random, now_us);
  rs_route_boot(cell, now_us);
  rs_sampling_refresh(cell, now_us);
  rs_timer_set(cell, now_us);
  rs_cell_seal(cell);
}

static void forward_up(rs_cell* cell, unsigned port, const uint8_t* received, uint32_t now_us) {
  RS_WORDS uint8_t frame[RS_FRAME_BYTES];
  memcpy(frame, received, RS_FRAME_BYTES);
  /* The order of distances forbids this; should it happen all the same, the time to live ends it. */
  if (port + 1U == cell->route.parent_port) ++cell->counts.frames_from_parent;
  if (!rs_frame_take_hop(frame)) {
    ++cell->counts.hops_exhausted;
    return;
  }
  rs_queue_up(cell, frame, now_us);
}

static RS_NOINLINE void receive(rs_cell* cell, unsigned port, const rs_input* input, uint32_t now_us) {
  const uint8_t* frame = input->frame;
  rs_neighbour* neighbour = &cell->route.neighbour[port];
  if (rs_tags_closed(cell, port)) return;
  if (!input->checked && !rs_frame_intact(frame)) {
    ++cell->counts.frames_damaged;
    rs_link_damage(neighbour, now_us);
    if (port + 1U == cell->route.parent_port && rs_link_lossy(neighbour, now_us)) {
      rs_queues_repeat_lossy(cell, now_us);
    }
    return;
  }
  rs_link_heard(cell, port, now_us);
  switch (rs_frame_type_of(frame)) {
    case RS_TYPE_event:
      rs_arq_receiver_count(&neighbour->arq_receiver);
      forward_up(cell, port, frame, now_us);
      break;
    case RS_TYPE_torque:
      rs_arq_receiver_count(&neighbour->arq_receiver);
      rs_torque_receive(cell, port, frame, input->late_us, now_us);
      break;
    case RS_TYPE_clock:
    case RS_TYPE_further:
    case RS_TYPE_topology:
    case RS_TYPE_reply:
    case RS_TYPE_join:
      forward_up(cell, port, frame, now_us);
      break;
    case RS_TYPE_tick:
      rs_beacon_tick(cell, port, frame, now_us - input->late_us, now_us);
      break;
    case RS_TYPE_status:
      if (neighbour->child) {
        rs_subtree_status(cell, port, frame);
      } else {
        ++cell->counts.frames_unknown;
      }
      break;
    case RS_TYPE_grant:
      rs_move_grant(cell, port, frame, now_us);
      break;
    case RS_TYPE_joints:
      if (port + 1U == cell->route.parent_port) {
        rs_joints_receive(cell, port, frame, now_us);
      } else {
        ++cell->counts.frames_unknown;
      }
      break;
    case RS_TYPE_command:
      if (port + 1U == cell->route.parent_port) {
        rs_command_receive(cell, port, frame, now_us);
      } else {
        ++cell->counts.frames_unknown;
      }
      break;
    default:
      ++cell->counts.frames_unknown;
      break;
  }
}

/* The time left from now until a later one that is at most `limit_us` away; 0 if it has come. */
static uint32_t left_us(uint32_t time_us, uint32_t limit_us, uint32_t now_us) {
  const uint32_t left = time_us - now_us;
  return left <= limit_us ? left : 0U;
}

/* After a step the long way: until when the short one may be taken. */
static void pass_note(rs_cell* cell, uint32_t now_us) {
  const rs_torque_epoch* epoch = &cell->torque;
  rs_queues* queues = &cell->queues;
  uint32_t calm_us = left_us(cell->timer_us, RS_HEARTBEAT_US, now_us);
  const uint32_t begin_us = left_us(epoch->begin_us, INT32_MAX, now_us);
  if (begin_us < calm_us) calm_us = begin_us;
  if (epoch->open) {
    const uint32_t deadline_us = left_us(epoch->deadline_us, RS_TORQUE_WAIT_MAX_US, now_us);
    if (deadline_us < calm_us) calm_us = deadline_us;
  }
  if (cell->route.origin_us != epoch->origin_us) calm_us = 0;
  queues->parent_port = cell->route.parent_port;
  queues->parent_bit = (uint8_t)(1U << queues->parent_port >> 1);
  queues->samples_next = rs_samples_next(cell);
  queues->calm_us = now_us + (queues->parent_port != RS_NO_PARENT ? calm_us : 0U);
}

/* A new parent has to be told what the last one was. */
RS_INLINE void follow_parent(rs_cell* cell, uint32_t now_us) {
  const rs_arq_sender* arq_sender = &cell->arq_sender;
  if (arq_sender->parent_port != cell->route.parent_port || arq_sender->parent_changes != cell->counts.parent_changes) {
    rs_arq_sender_move(cell, now_us);
  }
}

/* Epochs begin and end by the tick time. */
RS_INLINE void follow_epoch(rs_cell* cell, const rs_input* input, uint32_t now_us) {
  const rs_torque_epoch* epoch = &cell->torque;
  if (epoch->open || cell->route.origin_us != epoch->origin_us || rs_reached(now_us, epoch->begin_us)) {
    rs_torque_advance(cell, input->kind == RS_INPUT_FRAME ? input->late_us : 0U, now_us);
  }
}

RS_NOINLINE void rs_step(rs_cell* cell, const rs_input* input, uint32_t now_us, rs_output* output) {
  *output = (rs_output){.timer_us = now_us + RS_TOPOLOGY_US};
  if (input->kind == RS_INPUT_BOOT) {
    boot(cell, input->boot, now_us);
  } else if (cell->uid == 0U) {
    output->restart = true;
    return;
  }
  rs_cell_hold_indices(cell);
  /* Found out first: what comes in may set the timer anew, and would put off for ever what is due at its very moment.
   */
  const bool due = rs_reached(now_us, cell->timer_us) || cell->timer_us - now_us > RS_HEARTBEAT_US;
  const unsigned port = (unsigned)input->port - 1U;
  cell->queues.busy &= (uint8_t)~input->sent;
  switch (input->kind) {
    case RS_INPUT_FRAME:
      if (port < RS_PORTS) receive(cell, port, input, now_us);
      break;
    case RS_INPUT_SENT:
      if (port < RS_PORTS) cell->queues.busy &= (uint8_t)~(1U << port);
      break;
    case RS_INPUT_SAMPLE:
      rs_sampling_take(cell, input->sample, input->fault, now_us);
      break;
    default:
      break;
  }
  if (due) {
    /* What is damaged of the tree heals by itself; what came with the boot does not. */
    if (!rs_cell_sealed(cell)) {
      output->restart = true;
      return;
    }
    check(cell, now_us);
  }
  follow_parent(cell, now_us);
  follow_epoch(cell, input, now_us);
  rs_transmit(cell, now_us, output);
  pass_note(cell, now_us);

  output->timer_us = cell->timer_us;
  output->sampling = cell->sampling.running;
  output->sample_us = cell->sampling.due_us;
  if (cell->led_changed) {
    cell->led_changed = false;
    output->led_changed = true;
    output->led_rgb = cell->led_rgb;
  }
  if (cell->flash_changed) {
    cell->flash_changed = false;
    output->flash_changed = true;
    output->flash = cell->flash;
  }
}
