/* SPDX-License-Identifier: Apache-2.0
 * When the cell has something to do again without being asked: the least of the waits of all its parts. */
#include "cell/time/timer.h"

uint32_t rs_beacon_wait_us(const rs_cell* cell, unsigned port, uint32_t now_us) {
  const rs_queues* queues = &cell->queues;
  const uint32_t since_us = now_us - queues->beacon_us[port][queues->beacon_next[port] % RS_BEACONS];
  return since_us < RS_BEACONS_US ? RS_BEACONS_US - since_us : 0U;
}

/* A bucket that holds a burst of status frames and fills again by one in each mean time; `status_spent_us` is when it
 * is full. A time further off than an empty bucket needs is damaged memory. */
static uint32_t status_spent_us(const rs_cell* cell, uint32_t now_us) {
  const uint32_t spent_us = cell->route.status_spent_us - now_us;
  return spent_us <= RS_STATUS_BURST * RS_STATUS_MEAN_US ? spent_us : 0U;
}

uint32_t rs_status_wait_us(const rs_cell* cell, uint32_t now_us) {
  const uint32_t since_us = now_us - cell->route.reported_us;
  const uint32_t pause_us = since_us < RS_STATUS_PAUSE_US ? RS_STATUS_PAUSE_US - since_us : 0U;
  /* Offers use the upper half of the bucket, so that levelling leaves sizes a burst. */
  const uint32_t burst = cell->queues.size_due ? RS_STATUS_BURST : RS_STATUS_BURST / 2U;
  const uint32_t spent_us = status_spent_us(cell, now_us), enough_us = (burst - 1U) * RS_STATUS_MEAN_US;
  const uint32_t fill_us = spent_us > enough_us ? spent_us - enough_us : 0U;
  return pause_us > fill_us ? pause_us : fill_us;
}

void rs_status_note(rs_cell* cell, uint32_t now_us) {
  cell->route.status_spent_us = now_us + status_spent_us(cell, now_us) + RS_STATUS_MEAN_US;
  cell->route.reported_us = now_us;
}

uint32_t rs_torque_wait_us(const rs_cell* cell, uint32_t now_us) {
  const rs_torque_epoch* epoch = &cell->torque;
  if (epoch->open) {
    /* Overdue, it waits only for what came sooner. */
    const uint32_t left_us = epoch->deadline_us - now_us;
    return left_us - 1U < RS_TORQUE_WAIT_MAX_US ? left_us : 1U;
  }
  return epoch->own.parts > 0U || epoch->used > 0U ? epoch->begin_us - now_us : RS_HEARTBEAT_US;
}

/* The sooner of two waits. What is overdue looks far away on a clock that wraps, and is done at the check that ends
 * this wait. */
RS_INLINE uint32_t sooner(uint32_t wait_us, uint32_t limit_us) {
  return limit_us - 1U < wait_us ? limit_us : wait_us;
}

void rs_timer_set(rs_cell* cell, uint32_t now_us) {
  const rs_route* route = &cell->route;
  uint32_t wait_us = sooner(RS_HEARTBEAT_US, route->beacon_sent_us + RS_HEARTBEAT_US - now_us);
  wait_us = sooner(wait_us, rs_torque_wait_us(cell, now_us));
  if (route->handover) wait_us = sooner(wait_us, route->handover_us + rs_move_longest_us(route) - now_us);
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
  for (unsigned due = cell->queues.beacon_due, port = 0; due != 0U; due >>= 1, ++port) {
    if ((due & 1U) != 0U) wait_us = sooner(wait_us, rs_beacon_wait_us(cell, port & 3U, now_us));
  }
  cell->timer_us = now_us + wait_us;
}
