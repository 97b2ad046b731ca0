// SPDX-License-Identifier: Apache-2.0
#include "campaign/forgery_checker.hpp"

#include <cstring>

namespace robotskin::campaign {
namespace {

bool same_wave(const rs_wave& a, const rs_wave& b) {
  return a.tag == b.tag && a.sequence == b.sequence && a.era == b.era && a.root == b.root;
}

template <typename Value>
bool same_bytes(const Value& a, const Value& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

}  // namespace

void ForgeryChecker::frame_planted(const world::Network& network, const GroundTruth& ground, const RouteChecker& routes,
                                   std::size_t cell, unsigned port, const std::uint8_t* frame, bool forged) {
  const rs_cell& state = network.cell(cell);
  Planted& planted = planted_frame_;
  planted = {};
  ++planted_;
  if (ground.lawless(network.time_ns(), cell) || ground.tags_spent(ground.wire_of_cell(cell, port))) return;
  planted.waits = true;
  planted.forged = forged;
  planted.cell = cell;
  planted.port = port;
  planted.type = rs_frame_type_of(frame);
  if (planted.type == RS_TYPE_tick) {
    rs_tick tick;
    rs_tick_unpack(&tick, frame);
    planted.wave.tag = tick.tag;
    planted.wave.sequence = static_cast<std::uint16_t>(tick.sequence);
    planted.wave.era = static_cast<std::uint16_t>(tick.era);
    planted.wave.root = static_cast<std::uint8_t>(tick.root);
    planted.no_tag = !forged && tick.root == 0;
  }
  planted.may_take_time = !forged && routes.cannot_know_time(cell);
  planted.route = state.route;
  planted.settings = state.settings;
  planted.joints = state.joints;
  planted.led_rgb = state.led_rgb;
  planted.id = state.id;
  planted.unnamed = state.turn == RS_TURN_NONE;
  planted.counter = state.commanding.counter;
  planted.down = state.queues.down.count;
}

void ForgeryChecker::cell_stepped(const world::Network& network, std::size_t cell) {
  Planted& before = planted_frame_;
  if (!before.waits || before.cell != cell) return;
  before.waits = false;
  const rs_cell& state = network.cell(cell);
  const rs_route& route = state.route;
  const Invariant invariant = before.forged ? Invariant::forged : Invariant::replayed;
  const auto tell = [&](std::string_view what, std::int64_t now, std::int64_t then) {
    breaks_.add(invariant, network.time_ns(), {cell},
                {{"frame type", before.type}, {"port", before.port}, {what, now}, {"before", then}});
  };
  if (before.type == RS_TYPE_tick) {
    const bool misled = before.no_tag || (before.may_take_time && same_wave(route.wave, before.wave));
    if (route.parent_port != before.route.parent_port && !misled)
      tell("parent port", route.parent_port, before.route.parent_port);
    else if (!same_wave(route.wave, before.route.wave) && !misled)
      tell("tick number", route.wave.sequence, before.route.wave.sequence);
    const rs_neighbour& now = route.neighbour[before.port - 1];
    const rs_neighbour& then = before.route.neighbour[before.port - 1];
    if (before.forged && !same_wave(now.wave, then.wave))
      tell("neighbour's tick number", now.wave.sequence, then.wave.sequence);
    // The frame itself is heard, and may bring a link up or find that it was down.
    const bool stays_up = now.up == then.up;
    if (before.forged && stays_up && now.child != then.child) tell("neighbour is a child", now.child, then.child);
    if (before.forged && stays_up && now.draining != then.draining)
      tell("neighbour leaves", now.draining, then.draining);
  }
  if (route.handover != before.route.handover) tell("moves", route.handover, before.route.handover);
  if (!same_bytes(route.demands, before.route.demands))
    tell("round of wants", route.demands.round, before.route.demands.round);
  if (!same_bytes(state.settings, before.settings)) tell("mode", state.settings.mode, before.settings.mode);
  if (!same_bytes(state.joints, before.joints)) tell("joint", state.joints.position[0], before.joints.position[0]);
  if (state.led_rgb != before.led_rgb) tell("LED", state.led_rgb, before.led_rgb);
  if (state.id != before.id) tell("id", state.id, before.id);
  if (state.commanding.counter != before.counter) tell("command counter", state.commanding.counter, before.counter);
  // A command that comes twice is passed on, in case it was missed further down.
  // One that has no name yet cannot read commands, and passes them on.
  const bool unread = before.type == RS_TYPE_command && before.unnamed;
  if (!unread && state.queues.down.count > before.down && (before.forged || before.type != RS_TYPE_command))
    tell("frames to pass on", state.queues.down.count, before.down);
}

}  // namespace robotskin::campaign
