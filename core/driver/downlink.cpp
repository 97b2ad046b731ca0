// SPDX-License-Identifier: Apache-2.0
// What goes down to the section units: keep-alives, joint positions, commands to cells, power of ports.
#include <algorithm>

#include "driver/driver.hpp"

namespace robotskin::driver {
namespace {

// Joint positions leave in the middle of an epoch, so that they are with every cell when the next one begins.
constexpr std::int64_t joints_phase_ns = Driver::epoch_ns / 2;

constexpr std::int32_t counter_leap = 0x5555;
constexpr std::int64_t commands_patience_ns = 1'000'000'000;

}  // namespace

std::optional<std::uint32_t> Driver::command(Command command) {
  command.ticket = ticket_ + 1;
  if (!commands_.push(command)) return std::nullopt;
  return ++ticket_;
}

bool Driver::joints(const LimbJoints& joints) {
  if (joints.set_ns <= 0 || joints.limb > 15 || joints.joints == 0 || joints.joints > joints.position.size())
    return false;
  std::size_t at = 0;
  while (at < limbs_ && (joints_.row(at).group != joints.group || joints_.row(at).limb != joints.limb)) {
    ++at;
  }
  if (at == limbs_max) return false;
  if (at == limbs_) ++limbs_;
  joints_.change(at) = joints;
  joints_.publish(joints.set_ns);
  return true;
}

void Driver::downlink(std::int64_t now_ns, const Sink& sink) {
  for (PendingUnit& pending : pending_units_) {
    if (!pending.due) continue;
    pending.due = false;
    send(RS_DATAGRAM_KIND_keep_alive, 0, pending.unit, pending.session, now_ns, sink);
    statistics_.keep_alives_sent.add();
  }
  if (keep_alive_due_ || now_ns - keep_alive_ns_ >= RS_KEEP_ALIVE_MS * std::int64_t{1'000'000}) {
    keep_alive_due_ = false;
    keep_alive_ns_ = now_ns;
    keep_alive(now_ns, sink);
  }
  send_joints(now_ns, sink);
  send_commands(now_ns, sink);
}

void Driver::keep_alive(std::int64_t now_ns, const Sink& sink) {
  // With answering 0 it wakes units that have not been heard yet, or have restarted.
  for (const CellIndex::Group& group : index_.groups()) {
    send(RS_DATAGRAM_KIND_keep_alive, 0, {group.number, RS_UNIT_ALL}, 0, now_ns, sink);
    statistics_.keep_alives_sent.add();
  }
  for (std::size_t i = 0; i < unit_count_; ++i) {
    const UnitRow& unit = units_.row(i);
    if (silent(unit, now_ns)) continue;
    send(RS_DATAGRAM_KIND_keep_alive, 0, {unit.group, unit.unit}, unit.session, now_ns, sink);
    statistics_.keep_alives_sent.add();
  }
}

// A command goes out when its counter can be known and, within a second, each group has been heard.
bool Driver::ready_to_command(std::int64_t now_ns) {
  if (command_counter_ < 0) return false;
  if (now_ns - counter_known_ns_ > commands_patience_ns) return true;
  return std::ranges::all_of(index_.groups(), [this](const CellIndex::Group& group) {
    for (std::size_t i = 0; i < unit_count_; ++i) {
      if (unit_names_[i] >> 8 == group.number) return true;
    }
    return false;
  });
}

void Driver::send_commands(std::int64_t now_ns, const Sink& sink) {
  const auto send_to_units = [&](rs_datagram_kind kind, std::uint16_t group, std::uint8_t which) {
    for (std::size_t i = 0; i < unit_count_; ++i) {
      const UnitRow& unit = units_.row(i);
      if (unit.group != group || (which != RS_UNIT_ALL && which != unit.unit)) continue;
      send(kind, 1, {unit.group, unit.unit}, unit.session, now_ns, sink);
    }
  };
  std::uint8_t* record = out_.data() + RS_DATAGRAM_HEADER_BYTES;
  if (command_counter_ >= 0 && leap_.exchange(false, std::memory_order_acq_rel)) {
    command_counter_ = static_cast<std::uint16_t>(command_counter_ + counter_leap);
  }
  while (ready_to_command(now_ns)) {
    const std::optional<Command> command = commands_.pop();
    if (!command) break;
    command_counter_ = static_cast<std::uint16_t>(command_counter_ + 1);
    const auto counter = static_cast<std::uint16_t>(command_counter_);
    sent_[counter % sent_.size()] = {command->ticket, counter};
    rs_command frame{};
    frame.type = RS_TYPE_command;
    frame.target = command->target;
    frame.operation = command->operation;
    frame.counter = counter;
    frame.index = command->index;
    frame.value_high = static_cast<std::uint32_t>(command->value >> 32) & 0xFFFFU;
    frame.value_low = static_cast<std::uint32_t>(command->value);
    rs_command_pack(record, &frame);
    rs_record_arrival_pack(record, 0, 0);
    send_to_units(RS_DATAGRAM_KIND_inject, command->group, RS_UNIT_ALL);
    statistics_.commands_sent.add();
  }
  while (const std::optional<Power> power = powers_.pop()) {
    std::fill_n(record, RS_DATAGRAM_RECORD_BYTES, std::uint8_t{0});
    record[0] = power->on ? 1 : 0;
    rs_record_arrival_pack(record, power->port, 0);
    send_to_units(RS_DATAGRAM_KIND_power, power->group, power->unit);
  }
}

// Once an epoch to each section unit, which tells its cells the epoch; positions that have grown old are not sent.
void Driver::send_joints(std::int64_t now_ns, const Sink& sink) {
  const std::span<const LimbJoints> limbs = joints_.read();
  for (std::size_t i = 0; i < unit_count_; ++i) {
    const UnitRow& unit = units_.row(i);
    Link& link = links_[i];
    if (silent(unit, now_ns)) continue;
    // Without signs: a foreign datagram may claim any time, and its offset then wraps.
    const auto unit_ns = static_cast<std::int64_t>(static_cast<std::uint64_t>(now_ns) -
                                                   static_cast<std::uint64_t>(link.clock.offset_ns()) -
                                                   static_cast<std::uint64_t>(joints_phase_ns));
    const std::int64_t epoch = unit_ns / epoch_ns;
    if (epoch == link.joints_epoch) continue;
    std::uint8_t* record = out_.data() + RS_DATAGRAM_HEADER_BYTES;
    std::uint16_t count = 0;
    for (const LimbJoints& limb : limbs) {
      if (limb.set_ns == 0 || limb.group != unit.group || now_ns - limb.set_ns > joints_fresh_ns) continue;
      for (unsigned part = 0; RS_JOINTS_PER_PART * part < limb.joints && count < RS_DATAGRAM_RECORDS_MAX; ++part) {
        const std::int16_t* position = &limb.position[std::size_t{RS_JOINTS_PER_PART} * part];
        const rs_joints frame{.type = RS_TYPE_joints,
                              .epoch = 0,  // by the section unit
                              .limb = limb.limb,
                              .part = part,
                              .joint_1 = position[0],
                              .joint_2 = position[1],
                              .joint_3 = position[2],
                              .joint_4 = position[3],
                              .joint_5 = position[4],
                              .joint_6 = position[5],
                              .tag = 0};
        rs_joints_pack(record, &frame);
        rs_record_arrival_pack(record, 0, 0);
        record += RS_DATAGRAM_RECORD_BYTES;
        ++count;
      }
    }
    if (count == 0) continue;
    link.joints_epoch = epoch;
    send(RS_DATAGRAM_KIND_inject, count, {unit.group, unit.unit}, unit.session, now_ns, sink);
    statistics_.joints_sent.add(count);
  }
}

// Completes and hands over the datagram whose records stand in out_.
void Driver::send(rs_datagram_kind kind, std::uint16_t count, const Recipient& to, std::uint32_t answering,
                  std::int64_t now_ns, const Sink& sink) {
  rs_datagram_header header{};
  header.kind = static_cast<std::uint8_t>(kind);
  header.flags = hash_ ? RS_DATAGRAM_KEYED : 0;
  header.group = to.group;
  header.unit = to.unit;
  header.session = session_;
  header.sequence = ++sequence_;
  header.time_ns = static_cast<std::uint64_t>(now_ns + calendar_ns_);
  header.count = count;
  header.answering = answering;
  rs_datagram_header_pack(out_.data(), &header);
  std::size_t bytes = RS_DATAGRAM_HEADER_BYTES + std::size_t{header.count} * RS_DATAGRAM_RECORD_BYTES;
  if (hash_) {
    const Tag tag = hash_->tag({out_.data(), bytes});
    std::copy(tag.begin(), tag.end(), out_.begin() + static_cast<std::ptrdiff_t>(bytes));
    bytes += tag.size();
  }
  sink(to, {out_.data(), bytes});
}

}  // namespace robotskin::driver
