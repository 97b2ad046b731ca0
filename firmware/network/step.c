#include <string.h>

#include "cell/parts.h"

/* The sooner of two waits. What is overdue looks far away on a clock that wraps, and is done at the check that ends
 * this wait. */
RS_INLINE uint32_t sooner(uint32_t wait_us, uint32_t limit_us) {
  return limit_us - 1U < wait_us ? limit_us : wait_us;
}

void rs_timer_set(rs_cell* cell, uint32_t now_us) {
  const rs_route* route = &cell->route;
  uint32_t wait_us = sooner(RS_HEARTBEAT_US, route->advertised_us + RS_HEARTBEAT_US - now_us);
  wait_us = sooner(wait_us, rs_torque_wait_us(cell, now_us));
  if (route->hold) wait_us = sooner(wait_us, route->hold_us + rs_move_longest_us(route) - now_us);
  if (route->in_quarantine) wait_us = sooner(wait_us, route->quarantine_us - now_us);
  if (route->parent_port != RS_NO_PARENT) {
    /* What is asked for at least so often brings the checks of all else, and is itself never looked past. */
    const uint32_t since_us = now_us - route->reported_us;
    const uint32_t due_us = since_us < RS_STATUS_US ? RS_STATUS_US - since_us : 1U;
    wait_us = sooner(wait_us, cell->queues.status_due ? rs_status_wait_us(cell, now_us) : due_us);
  }
  wait_us = sooner(wait_us, (cell->id == RS_ID_NONE ? cell->join_us : cell->topology_us) - now_us);
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    const rs_neighbour* neighbour = &route->neighbour[port];
    if (neighbour->up) wait_us = sooner(wait_us, neighbour->heard_us + RS_LINK_DOWN_US - now_us);
  }
  for (unsigned due = cell->queues.advert_due, port = 0; due != 0U; due >>= 1, ++port) {
    if ((due & 1U) != 0U) wait_us = sooner(wait_us, rs_advert_wait_us(cell, port & 3U, now_us));
  }
  cell->timer_us = now_us + wait_us;
}

static RS_APART void check(rs_cell* cell, uint32_t now_us) {
  rs_queues_check(cell, now_us);
  rs_retention_check(cell, now_us);
  rs_torque_check(cell);
  rs_cell_heal_settings(cell, now_us);
  rs_sampling_check(cell, now_us);
  rs_route_check(cell, now_us);
  rs_identity_check(cell, now_us);
  if (cell->route.parent_port != RS_NO_PARENT && now_us - cell->route.reported_us >= RS_STATUS_US) {
    cell->queues.status_due = true;
  }
  rs_timer_set(cell, now_us);
}

static RS_APART uint32_t lasting(const rs_cell* cell) {
  uint32_t sum = cell->uid ^ ((uint32_t)cell->id << 8) ^ cell->keyed ^ 0x5EA1U;
  for (unsigned i = 0; i < sizeof cell->key.word / sizeof cell->key.word[0]; ++i) {
    sum = ((sum << 5) | (sum >> 27)) ^ cell->key.word[i];
  }
  return sum;
}

typedef uint16_t RS_ALIAS halfword;

uint32_t rs_sum_of(const void* halfwords, uint32_t count) {
  const halfword* half = halfwords;
  uint32_t sum = 0x5EA1U;
  for (uint32_t i = 0; i < count / 2U; ++i) sum = ((sum << 5) | (sum >> 27)) + half[i];
  return sum == 0U ? 1U : sum;
}

RS_STATIC_ASSERT(sizeof(rs_settings) % 2 == 0 && sizeof(rs_contribution) % 2 == 0 &&
                     sizeof(rs_torque_parameters) % 2 == 0 && _Alignof(rs_torque_parameters) == 2,
                 "what has a sum are whole halfwords");

void rs_cell_keep_settings(rs_cell* cell) {
  cell->settings_copy = cell->settings;
  cell->settings_sum = cell->settings_copy_sum = rs_sum_of(&cell->settings, sizeof cell->settings);
}

void rs_cell_heal_settings(rs_cell* cell, uint32_t now_us) {
  if (cell->led_rgb != ~cell->led_complement) {
    cell->led_rgb = 0;
    cell->led_complement = ~cell->led_rgb;
    cell->led_changed = true;
  }
  const bool whole = cell->settings_sum == rs_sum_of(&cell->settings, sizeof cell->settings);
  if (whole && cell->settings_copy_sum == cell->settings_sum) return;
  if (!whole) {
    if (cell->settings_copy_sum == rs_sum_of(&cell->settings_copy, sizeof cell->settings_copy)) {
      cell->settings = cell->settings_copy;
    } else {
      rs_settings_load(&cell->settings, cell->flash);
    }
    rs_sampling_restart(cell, now_us);
  }
  rs_cell_keep_settings(cell);
}

void rs_cell_seal(rs_cell* cell) {
  cell->lasting = lasting(cell);
}

static RS_APART void boot(rs_cell* cell, const rs_boot* with, uint32_t now_us) {
  memset(cell, 0, sizeof *cell);
  cell->uid = with->uid;
  rs_settings_load(&cell->settings, with->flash);
  rs_cell_keep_settings(cell);
  cell->led_complement = ~cell->led_rgb;
  if (with->flash != 0) memcpy(cell->flash, with->flash, RS_FLASH_BYTES);
  rs_own_torque_load(cell);
  cell->keyed = with->key != 0;
  if (cell->keyed) rs_chaskey_key_expand(&cell->key, with->key);
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

static RS_APART void receive(rs_cell* cell, unsigned port, const uint8_t* frame, bool checked, uint32_t now_us) {
  rs_neighbour* neighbour = &cell->route.neighbour[port];
  if (!checked && !rs_frame_intact(frame)) {
    ++cell->counts.frames_damaged;
    rs_link_damage(neighbour, now_us);
    if (port + 1U == cell->route.parent_port && rs_link_spoilt(neighbour, now_us)) {
      rs_queues_repeat_spoilt(cell, now_us);
    }
    return;
  }
  rs_link_heard(cell, port, now_us);
  switch (rs_frame_type_of(frame)) {
    case RS_TYPE_event:
      rs_hearing_count(&neighbour->hearing);
      forward_up(cell, port, frame, now_us);
      break;
    case RS_TYPE_torque:
      rs_hearing_count(&neighbour->hearing);
      rs_torque_receive(cell, port, frame, now_us);
      break;
    case RS_TYPE_clock:
    case RS_TYPE_topology:
    case RS_TYPE_reply:
    case RS_TYPE_join:
      forward_up(cell, port, frame, now_us);
      break;
    case RS_TYPE_tick:
      rs_advert_tick(cell, port, frame, now_us);
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
        rs_joints_receive(cell, frame, now_us);
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

RS_APART void rs_step(rs_cell* cell, const rs_input* input, uint32_t now_us, rs_output* output) {
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
      if (port < RS_PORTS) receive(cell, port, input->frame, input->checked, now_us);
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
    if (cell->lasting != lasting(cell)) {
      output->restart = true;
      return;
    }
    check(cell, now_us);
  }
  rs_retention_follow(cell, now_us);
  rs_torque_follow(cell, now_us);
  rs_transmit(cell, now_us, output);
  rs_pass_note(cell, now_us);

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
