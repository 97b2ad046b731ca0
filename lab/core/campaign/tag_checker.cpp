// SPDX-License-Identifier: Apache-2.0
#include "campaign/tag_checker.hpp"

#include <algorithm>
#include <vector>

#include "robotskin/keys.h"
#include "robotskin/operations.h"

namespace robotskin::campaign {
namespace {

constexpr std::size_t covered = 14;  // first bytes of a frame
constexpr std::uint32_t turn_bits = 26, second_bits = 10, epoch_low_bits = 6;

void append(std::vector<std::uint8_t>& message, std::uint64_t value, int bytes) {
  while (bytes-- > 0) message.push_back(static_cast<std::uint8_t>(value >> 8 * bytes));
}

std::uint32_t tag_of(const MacBytes& key, const std::vector<std::uint8_t>& message) {
  const MacBytes mac = published_mac(key, message);
  return std::uint32_t{mac[0]} << 24 | std::uint32_t{mac[1]} << 16 | std::uint32_t{mac[2]} << 8 | mac[3];
}

std::vector<std::uint8_t> beginning(const std::uint8_t* frame) {
  return {frame, frame + covered};
}

}  // namespace

TagChecker::TagChecker(std::optional<MacBytes> secret, BreakLog& breaks) : breaks_(breaks), secret_(secret) {
  constexpr std::array<std::uint8_t, 1> of_group{1};
  if (secret_) group_ = published_mac(*secret_, of_group);
}

MacBytes TagChecker::of_cell(std::uint32_t uid) const {
  std::vector<std::uint8_t> message{2};
  append(message, uid, 4);
  return published_mac(*secret_, message);
}

MacBytes TagChecker::of_turn(const MacBytes& key, std::uint32_t turn) const {
  std::vector<std::uint8_t> message{3};
  append(message, turn, 4);
  return published_mac(key, message);
}

void TagChecker::frame_sent(const world::Network& network, std::size_t unit, const std::uint8_t* frame) {
  if (!secret_) return;
  const std::uint64_t time = network.unit(unit).tick_time;
  const unsigned type = rs_frame_type_of(frame);
  // A frame may have waited since the second, or the round of epochs, before.
  std::uint32_t tag = 0, now = 0, before = 0;
  const std::uint32_t turns = network.unit(unit).config.turns;
  const auto turn_at = [&](std::uint64_t at) {
    return (static_cast<std::uint32_t>(at >> turn_bits) + turns) & RS_TURN_MASK;
  };
  if (type == RS_TYPE_tick) {
    rs_tick tick;
    rs_tick_unpack(&tick, frame);
    std::vector<std::uint8_t> message;
    append(message, 0x30, 1);
    append(message, tick.era, 2);
    append(message, tick.sequence, 2);
    for (const std::uint32_t one : {tick.root, tick.forming, tick.depth_cap, tick.rate_divisor, tick.gain_threshold})
      append(message, one, 1);
    message.resize(16);
    tag = tick.tag;
    now = before = tag_of(group_, message);
  } else if (type == RS_TYPE_joints) {
    rs_joints joints;
    rs_joints_unpack(&joints, frame);
    tag = joints.tag;
    const std::uint64_t epoch = time / RS_EPOCH_TICKS;
    const auto of_round = [&](std::uint64_t at) {
      std::vector<std::uint8_t> message = beginning(frame);
      append(message, (at & ((1U << turn_bits) / RS_EPOCH_TICKS - 1U)) >> epoch_low_bits, 3);
      return tag_of(of_turn(group_, turn_at(at * RS_EPOCH_TICKS)), message);
    };
    now = of_round(epoch);
    before = of_round(epoch - (1U << epoch_low_bits));
  } else if (type == RS_TYPE_command || type == RS_TYPE_grant) {
    MacBytes key = group_;
    rs_command command;
    rs_command_unpack(&command, frame);
    tag = command.tag;
    if (type == RS_TYPE_command) {
      const bool by_uid = command.operation == RS_OPERATION_assign || command.operation == RS_OPERATION_rejoin;
      if (!by_uid && command.target != RS_ID_ALL) return;
      if (by_uid) key = of_cell(command.value_low);
    }
    const auto of_second = [&](std::uint64_t at) {
      std::vector<std::uint8_t> message = beginning(frame);
      append(message, at >> second_bits & 0xFFFFU, 2);
      return tag_of(of_turn(key, turn_at(at)), message);
    };
    now = of_second(time);
    before = of_second(time - (1U << second_bits));
  } else {
    return;
  }
  ++judged_;
  if (tag != now && tag != before)
    breaks_.add(
        Invariant::true_tag, network.time_ns(), {},
        {{"frame type", type}, {"section unit", static_cast<std::int64_t>(unit)}, {"tag", tag}, {"must be", now}});
}

void TagChecker::poll(const world::Network& network, const GroundTruth& ground) {
  if (!secret_) return;
  const std::int64_t now_ns = network.time_ns();
  for (std::size_t cell = 0; cell < network.cell_count(); ++cell) {
    const rs_cell& state = network.cell(cell);
    if (!ground.runs(cell) || !state.keyed || state.turn == RS_TURN_NONE || ground.lawless(now_ns, cell)) continue;
    const MacBytes key = of_turn(group_, state.turn);
    if (!std::ranges::equal(key, state.turn_key))
      breaks_.add(Invariant::true_tag, now_ns, {cell}, {{"turn of a wrong key", state.turn}});
  }
}

}  // namespace robotskin::campaign
