/* SPDX-License-Identifier: Apache-2.0
 * Commands: which are genuine and new, what they change, and the reply. */
#include "cell/commands.h"

#include <string.h>

#include "cell/memory/integrity.h"
#include "cell/memory/known_time.h"
#include "cell/memory/turn.h"
#include "cell/routing/identity.h"
#include "cell/routing/refusal.h"
#include "cell/routing/wrong_tags.h"
#include "cell/time/sample_clock.h"
#include "cell/time/tick_time.h"
#include "cell/time/timer.h"
#include "cell/torque/cell_torque.h"
#include "cell/transport/queues.h"
#include "cell/wire/tags.h"
#include "cell/wire/wave.h"
#include "robotskin/crc.h"
#include "robotskin/feasibility.h"
#include "robotskin/operations.h"

enum {
  TICK_TIME_MASK = (1 << RS_TICK_TIME_BITS) - 1,
  COUNTER_LIFE_MS = 2 * 65536 /* after this no recorded command passes its tag any more, whatever its counter */
};

static bool authentic(const rs_cell* cell, const uint8_t* key, const uint8_t* frame, uint32_t tag, uint32_t now_us) {
  if (!cell->keyed) return true;
  const uint32_t time = rs_tick_time(cell, now_us);
  if (rs_tags_equal(rs_command_tag(key, frame, time), tag)) return true;
  /* It may have come from the second before, or the own time may be behind. */
  const uint32_t second = 1U << RS_TAG_SECOND_BITS;
  const uint32_t beside = (time & (second - 1U)) < second / 2U ? time - second : time + second;
  return rs_tags_equal(rs_command_tag(key, frame, beside), tag);
}

/* How many settings an operation has. */
static uint32_t indices_of(uint32_t operation) {
  if (operation == RS_OPERATION_threshold || operation == RS_OPERATION_offset) return RS_CHANNEL_COUNT;
  return operation == RS_OPERATION_torque_word ? RS_TORQUE_WORDS : 1U;
}

/* One setting by the number of its operation: where it lies decides index and range. */
static rs_reply_status set(rs_cell* cell, const rs_command* command, uint32_t now_us) {
  rs_settings* settings = &cell->settings;
  const uint32_t index = command->index, value = command->value_low;
  if (index >= indices_of(command->operation)) return RS_REPLY_bad_index;
  switch (command->operation) {
    case RS_OPERATION_clock_rate:
#define RATE_IS(rate_hz, period_us) (rate_hz) == value ||
      if (!(RS_CLOCK_RATES(RATE_IS) false)) return RS_REPLY_bad_value;
#undef RATE_IS
      settings->clock_rate_hz = (uint8_t)value;
      break;
    case RS_OPERATION_mode:
      if (value > RS_MODE_EVENT) return RS_REPLY_bad_value;
      settings->mode = (uint8_t)value;
      break;
    case RS_OPERATION_event_rate:
      if (value < RS_EVENT_RATE_MIN_HZ || value > RS_EVENT_RATE_MAX_HZ) return RS_REPLY_bad_value;
      settings->event_rate_hz = (uint16_t)value;
      break;
    case RS_OPERATION_threshold:
      if (value == 0U || value > 0xFFFFU) return RS_REPLY_bad_value;
      settings->threshold[index] = (uint16_t)value;
      return RS_REPLY_done;
    case RS_OPERATION_event_mask:
      if (value > RS_EVENT_MASK_ALL) return RS_REPLY_bad_value;
      settings->event_mask = (uint16_t)value;
      return RS_REPLY_done;
    case RS_OPERATION_offset:
      if (value > 0x7FFFU && value < 0xFFFF8000U) return RS_REPLY_bad_value;
      settings->offset[index] = (int16_t)((int32_t)((value & 0xFFFFU) ^ 0x8000U) - 0x8000);
      return RS_REPLY_done;
    case RS_OPERATION_led:
      if (value > 0xFFFFFFU) return RS_REPLY_bad_value;
      cell->led_rgb = value;
      cell->led_complement = ~value;
      cell->led_changed = true;
      return RS_REPLY_done;
    case RS_OPERATION_torque_word:
      rs_cell_torque_write(cell, command);
      return RS_REPLY_done;
    case RS_OPERATION_torque_commit:
      return rs_cell_torque_commit(cell, value) ? RS_REPLY_done : RS_REPLY_bad_value;
    default:
      return RS_REPLY_unknown_operation;
  }
  rs_sampling_restart(cell, now_us);
  return RS_REPLY_done;
}

static bool get(const rs_cell* cell, uint32_t operation, uint32_t index, uint32_t* value) {
  const rs_settings* settings = &cell->settings;
  switch (operation) {
    case RS_OPERATION_clock_rate:
      *value = settings->clock_rate_hz;
      return true;
    case RS_OPERATION_mode:
      *value = settings->mode;
      return true;
    case RS_OPERATION_event_rate:
      *value = settings->event_rate_hz;
      return true;
    case RS_OPERATION_threshold:
      *value = settings->threshold[index % RS_CHANNEL_COUNT];
      return true;
    case RS_OPERATION_event_mask:
      *value = settings->event_mask;
      return true;
    case RS_OPERATION_offset:
      *value = (uint32_t)(int32_t)settings->offset[index % RS_CHANNEL_COUNT];
      return true;
    case RS_OPERATION_led:
      *value = cell->led_rgb;
      return true;
    case RS_OPERATION_torque_word:
      *value = rs_load32(cell->flash + RS_FLASH_TORQUE_AT + index % RS_TORQUE_WORDS * RS_TORQUE_WORD_BYTES + 2);
      return true;
    case RS_OPERATION_torque_commit:
      *value = rs_cell_torque_checksum(cell);
      return true;
    default:
      return false;
  }
}

/* Carries a command out and puts the answer into `reply`. */
static void carry_out(rs_cell* cell, const rs_command* command, rs_reply* reply, uint32_t now_us) {
  reply->status = RS_REPLY_done;
  switch (command->operation) {
    case RS_OPERATION_ping:
      reply->value_low = rs_tick_time(cell, now_us);
      break;
    case RS_OPERATION_topology:
      cell->topology_us = now_us;
      break;
    case RS_OPERATION_store:
      cell->settings.id = cell->id;
      rs_settings_store(&cell->settings, cell->flash);
      cell->flash_changed = true;
      break;
    case RS_OPERATION_forget:
      cell->settings.id = RS_ID_NONE;
      memset(cell->flash, 0xFF, RS_FLASH_BYTES);
      cell->flash_changed = true;
      break;
    case RS_OPERATION_read:
      reply->value_high = command->value_low & 0xFFFFU;
      if (!get(cell, command->value_low, command->index, &reply->value_low)) {
        reply->status = RS_REPLY_bad_value;
      } else if (command->index >= indices_of(command->value_low)) {
        reply->status = RS_REPLY_bad_index;
        reply->value_low = 0;
      }
      break;
    default:
      reply->status = set(cell, command, now_us);
      reply->value_high = command->operation;
      get(cell, command->operation, command->index, &reply->value_low);
      break;
  }
}

static void answer(rs_cell* cell, const rs_command* command, uint32_t now_us) {
  rs_reply reply = {.type = RS_TYPE_reply,
                    .source = cell->id,
                    .ttl = RS_TTL_START,
                    .operation = command->operation,
                    .counter = command->counter,
                    .index = command->index,
                    .version = RS_FIRMWARE_VERSION};
  rs_cell_heal_settings(cell, now_us);
  carry_out(cell, command, &reply, now_us);
  rs_cell_keep_settings(cell);
  rs_commanding* commanding = &cell->commanding;
  commanding->replied = command->target == cell->id || command->operation == RS_OPERATION_ping;
  if (!commanding->replied) return;
  rs_reply_pack(commanding->reply, &reply);
  rs_frame_seal(commanding->reply);
  rs_queue_up(cell, commanding->reply, now_us);
}

static uint32_t sum_of(const rs_commanding* commanding) {
  const uint32_t counted[2] = {commanding->time, commanding->counter};
  return rs_sum_of(counted, sizeof counted);
}

static void count(rs_commanding* commanding, uint32_t counter, uint32_t time) {
  commanding->counted = true;
  commanding->counter = (uint16_t)counter;
  commanding->time = time;
  commanding->sum = sum_of(commanding);
  commanding->replied = false;
}

static void receive_counted(rs_cell* cell, const rs_command* command, const uint8_t* frame, uint32_t now_us) {
  rs_commanding* commanding = &cell->commanding;
  const bool for_us = cell->id != RS_ID_NONE;
  const uint32_t time = rs_tick_time(cell, now_us);
  const uint32_t since = rs_ticks_between(commanding->time, time);
  const bool expired = since > COUNTER_LIFE_MS && !rs_time_went_back(since);
  if (commanding->counted && !expired && commanding->sum == sum_of(commanding)) {
    if (command->counter == commanding->counter) {
      /* Sent again because a reply was missed: pass on, answer, but do nothing twice. */
      rs_queue_down(cell, frame);
      if (for_us && commanding->replied) rs_queue_up(cell, commanding->reply, now_us);
      return;
    }
    if (!rs_newer((uint16_t)command->counter, commanding->counter)) {
      ++cell->counts.commands_stale;
      return;
    }
  }
  rs_queue_down(cell, frame);
  count(commanding, command->counter, time);
  if (for_us) answer(cell, command, now_us);
}

/* A cell that knows no counter yet takes the one that comes with its name: what was recorded before has an older one.
 */
static void learn_counter(rs_cell* cell, uint32_t counter, uint32_t now_us) {
  if (cell->commanding.counted || !cell->keyed) return;
  count(&cell->commanding, counter, rs_tick_time(cell, now_us));
}

void rs_command_receive(rs_cell* cell, unsigned port, const uint8_t* frame, uint32_t now_us) {
  rs_command command;
  rs_command_unpack(&command, frame);
  const bool by_uid = command.operation == RS_OPERATION_assign || command.operation == RS_OPERATION_rejoin;
  const bool to_all = !by_uid && command.target == RS_ID_ALL;
  const bool to_us = by_uid ? command.value_low == cell->uid : cell->id != RS_ID_NONE && command.target == cell->id;
  if (!to_all && !to_us) {
    rs_queue_down(cell, frame); /* under the key of another cell, which alone can tell whether it is right */
    rs_timer_set(cell, now_us);
    return;
  }
  const bool naming = command.operation == RS_OPERATION_assign;
  if (naming && command.value_high != cell->challenge) return;
  if (cell->keyed && cell->turn == RS_TURN_NONE && !naming) {
    /* It cannot tell yet, and does nothing; those below can. */
    if (to_all) rs_queue_down(cell, frame);
    rs_timer_set(cell, now_us);
    return;
  }
  /* A parent passes on what is for all only if it is right, once it has a name. */
  const bool read_before = to_all && cell->route.neighbour[port].id != RS_ID_NONE;
  const unsigned place = read_before ? port : (unsigned)RS_UNREAD;
  if (rs_tags_closed(cell, place)) return;
  const uint32_t turn = naming ? command.target | command.spare << RS_TURN_LOW_BITS : cell->turn;
  uint8_t own_key[RS_CELL_KEY_BYTES] = {0};
  if (cell->keyed && !to_all) rs_key_of_turn(cell->keys + RS_CELL_KEY_BYTES, turn, own_key);
  if (!authentic(cell, to_all ? cell->turn_key : own_key, frame, command.tag, now_us)) {
    rs_refuse_tag(cell, place, now_us);
    return;
  }
  if (!by_uid) {
    receive_counted(cell, &command, frame, now_us);
  } else if (command.operation == RS_OPERATION_rejoin) {
    if (command.index == cell->id) rs_identity_rejoin(cell, now_us);
  } else if (command.index >= RS_ID_FIRST && command.index <= RS_ID_LAST) {
    if (cell->keyed) rs_turn_take(cell, turn);
    rs_identity_assign(cell, (uint16_t)command.index, now_us);
    learn_counter(cell, command.counter, now_us);
  }
  rs_timer_set(cell, now_us);
}
