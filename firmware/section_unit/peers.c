/* SPDX-License-Identifier: Apache-2.0
 * The units of a group agree on one time over Ethernet, so that ticks with one number leave all ports together.
 *
 * Each unit tells the others every few milliseconds what its time is and which units it hears. It follows the leader:
 * of those whose time is the latest (within RS_PEER_TOGETHER_US), the unit with the lowest number. A unit that has just
 * started takes the group's time at once, whatever its own clock says; later, time only ever goes forward, because to
 * cells a smaller number is an old tick. Parts of a group that cannot hear each other keep the time they agreed on. */
#include "section_unit/peers.h"

#include <stddef.h>

#include "section_unit/balance.h"
#include "section_unit/group_time.h"
#include "section_unit/uplink.h"

enum { NS_PER_US = 1000, NS_PER_MS = 1000000 };

static bool starting(const rs_section_unit* unit, uint64_t now_ns) {
  return now_ns - unit->booted_ns < (uint64_t)RS_PEER_STARTING_US * NS_PER_US;
}

/* How far the leader's time is before the own one. */
static int64_t behind_leader(const rs_section_unit* unit, uint64_t now_ns) {
  const int64_t together_ns = (int64_t)RS_PEER_TOGETHER_US * NS_PER_US;
  const bool newcomer = starting(unit, now_ns);
  bool settled = !newcomer;
  for (unsigned u = 0; u < RS_UNITS_MAX; ++u) {
    const rs_unit_peer* peer = &unit->peer[u];
    settled = settled || (rs_peer_counts(peer, now_ns) && peer->timed && (peer->flags & RS_PEER_STARTING) == 0);
  }
  bool found = false;
  int64_t latest_ns = 0;
  for (unsigned pass = 0; pass < 2U; ++pass) {
    for (unsigned u = 0; u < RS_UNITS_MAX; ++u) {
      const rs_unit_peer* peer = &unit->peer[u];
      const bool own = u == unit->config.unit;
      if (!own && (!rs_peer_counts(peer, now_ns) || !peer->timed)) continue;
      if (settled && (own ? newcomer : (peer->flags & RS_PEER_STARTING) != 0)) continue;
      const int64_t ahead_ns = own ? 0 : (int64_t)(peer->ahead_ns - unit->ahead_ns);
      if (pass == 0U) {
        if (!found || ahead_ns > latest_ns) latest_ns = ahead_ns;
        found = true;
      } else if ((uint64_t)latest_ns - (uint64_t)ahead_ns < (uint64_t)together_ns) {
        return ahead_ns;
      }
    }
  }
  return 0;
}

void rs_peers_keep_time(rs_section_unit* unit, uint64_t now_ns) {
  int64_t behind_ns = behind_leader(unit, now_ns);
  const int64_t together_ns = (int64_t)RS_PEER_TOGETHER_US * NS_PER_US;
  if (starting(unit, now_ns)) {
    unit->ahead_ns += (uint64_t)behind_ns;
    if (behind_ns >= NS_PER_MS || behind_ns <= -NS_PER_MS) {
      unit->tick_time = rs_unit_time(unit, now_ns) / (RS_TICK_US * NS_PER_US) - 1U;
    }
  } else if (behind_ns >= together_ns) {
    /* Cells take a leap once their own ticks have stood still for RS_STALE_TICKS; so the next one waits. */
    if (now_ns - unit->leapt_ns < 2U * (uint64_t)RS_STALE_US * NS_PER_US) return;
    const int64_t leap_ns = (int64_t)RS_PEER_LEAP_MS * NS_PER_MS;
    unit->ahead_ns += (uint64_t)(behind_ns < leap_ns ? behind_ns : leap_ns);
    unit->leapt_ns = now_ns;
  } else {
    const int64_t pull_ns = (int64_t)RS_PEER_PULL_US * NS_PER_US;
    if (behind_ns > pull_ns) behind_ns = pull_ns;
    if (behind_ns < -pull_ns) behind_ns = -pull_ns;
    unit->ahead_ns += (uint64_t)behind_ns;
  }
}

uint64_t rs_peers_send(rs_section_unit* unit, uint64_t now_ns, rs_unit_output* output) {
  if (now_ns < unit->peers_due_ns) return unit->peers_due_ns;
  const uint64_t period_us = starting(unit, now_ns) ? RS_PEER_STARTING_US / 6U : RS_PEER_US;
  unit->peers_due_ns = now_ns + period_us * NS_PER_US;
  uint8_t* record = unit->datagram + RS_DATAGRAM_HEADER_BYTES;
  const rs_peer_unit self = {
      .unit = unit->config.unit,
      .flags = (uint8_t)((starting(unit, now_ns) ? RS_PEER_STARTING : 0U) | (unit->forming ? RS_PEER_FORMING : 0U)),
      .session = unit->config.session,
      .sent_ns = (uint32_t)now_ns};
  rs_peer_unit_pack(record, &self);
  uint32_t count = 1;
  for (unsigned u = 0; u < RS_UNITS_MAX; ++u) {
    const rs_unit_peer* peer = &unit->peer[u];
    const uint64_t held_ns = now_ns - peer->heard_ns;
    if (!peer->heard || held_ns >= (uint64_t)RS_PEER_SILENCE_US * NS_PER_US) continue;
    const rs_peer_unit heard = {
        .unit = (uint8_t)u, .session = peer->session, .sent_ns = peer->sent_ns, .held_ns = (uint32_t)held_ns};
    rs_peer_unit_pack(record + RS_DATAGRAM_RECORD_BYTES * count, &heard);
    ++count;
  }
  count += rs_balance_pack(unit, record + RS_DATAGRAM_RECORD_BYTES * count, now_ns);
  output->to_peers = true;
  rs_datagram_finish(unit, RS_DATAGRAM_KIND_peer, count, now_ns, output);
  return unit->peers_due_ns;
}

/* Half of a round trip is the way, if both ways take the same time; exchanges that were held up on one of them tell
 * little, so only those near the shortest one count. */
static void compare_clocks(rs_unit_peer* peer, const rs_peer_unit* echo, uint64_t time_ns, uint64_t now_ns) {
  const uint32_t round_trip_ns = (uint32_t)now_ns - echo->sent_ns - echo->held_ns;
  if (round_trip_ns >= (uint32_t)RS_PEER_SILENCE_US * NS_PER_US) return;
  const uint32_t tolerance_ns = 20U * NS_PER_US;
  peer->round_trip_ns += NS_PER_US; /* a way that has become longer is believed in time */
  if (peer->timed && round_trip_ns > peer->round_trip_ns + tolerance_ns) return;
  if (!peer->timed || round_trip_ns < peer->round_trip_ns) peer->round_trip_ns = round_trip_ns;
  peer->timed = true;
  peer->ahead_ns = time_ns + round_trip_ns / 2U - now_ns;
}

bool rs_peers_receive(rs_section_unit* unit, const rs_datagram_header* header, const uint8_t* bytes, uint64_t now_ns) {
  if (header->unit >= RS_UNITS_MAX || header->unit == unit->config.unit || header->session == 0U) return false;
  if (header->count == 0U) return false;
  rs_unit_peer* peer = &unit->peer[header->unit];
  const uint8_t* record = bytes + RS_DATAGRAM_HEADER_BYTES;
  rs_peer_unit self, echo = {.session = 0};
  uint16_t ports = 0;
  rs_peer_unit_unpack(&self, record);
  if (rs_record_port(record) != 0U || self.unit != header->unit || self.session != header->session) return false;
  for (uint32_t i = 1; i < header->count; ++i) {
    const uint8_t* next = record + RS_DATAGRAM_RECORD_BYTES * i;
    if (rs_record_port(next) != 0U) {
      ports |= (uint16_t)(1U << (rs_record_port(next) - 1U));
      continue;
    }
    rs_peer_unit heard;
    rs_peer_unit_unpack(&heard, next);
    if (heard.unit == unit->config.unit && heard.session == unit->config.session) echo = heard;
  }

  if (peer->heard && header->session == peer->session) {
    const uint32_t ahead = header->sequence - peer->sequence;
    if (ahead == 0U || ahead >= 0x80000000U) return false;
  } else {
    /* A new session is answered at once, and counts when it answers; one of before would have an old time. */
    if (unit->config.tag != NULL && echo.session != 0U && header->time_ns <= peer->time_ns) return false;
    *peer = (rs_unit_peer){.heard = true, .session = header->session, .time_ns = peer->time_ns};
    unit->peers_due_ns = now_ns;
  }
  peer->sequence = header->sequence;
  peer->heard_ns = now_ns;
  peer->sent_ns = self.sent_ns;
  peer->flags = self.flags;
  peer->mutual = echo.session != 0U;
  peer->ports = 0;
  if (!peer->mutual) return true;
  peer->ports = ports;
  for (uint32_t i = 1; i < header->count; ++i) {
    const uint8_t* next = record + RS_DATAGRAM_RECORD_BYTES * i;
    if (rs_record_port(next) != 0U) rs_peer_tree_unpack(&peer->tree[rs_record_port(next) - 1U], next);
  }
  if ((peer->flags & RS_PEER_STARTING) == 0) peer->time_ns = header->time_ns;
  compare_clocks(peer, &echo, header->time_ns, now_ns);
  return true;
}
