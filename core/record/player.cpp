// SPDX-License-Identifier: Apache-2.0
#include "record/player.hpp"

#include <cstring>
#include <stdexcept>
#include <string>

#include "record/felt_state.hpp"
#include "skin/skin_input.hpp"

namespace robotskin::record {
namespace {

constexpr std::int64_t time_limit_ns = std::int64_t{1} << 61;
constexpr std::size_t queue_limit_bytes = std::size_t{1} << 30;

EntryHeader header_at(const std::vector<std::uint8_t>& bytes, std::size_t at) {
  EntryHeader header;
  std::memcpy(&header, bytes.data() + at, sizeof header);
  return header;
}

std::uint64_t number_of(const EntryQueue::View& entry) {
  std::uint64_t number = 0;
  if (entry.payload.size() != sizeof number) throw std::invalid_argument("recording: an entry of 8 bytes has others");
  std::memcpy(&number, entry.payload.data(), sizeof number);
  return number;
}

void take_doubles(std::span<const std::uint8_t> bytes, std::vector<double>& out) {
  if (bytes.size() % sizeof(double) != 0) throw std::invalid_argument("recording: numbers that are cut short");
  out.resize(bytes.size() / sizeof(double));
  std::memcpy(out.data(), bytes.data(), bytes.size());
}

driver::Options options_of(const skin::SkinModel& model, std::size_t spare_cells, std::size_t spare_groups) {
  driver::Options options;
  for (std::size_t i = 0; i < model.size(); ++i) options.keys.push_back(model.key[i]);
  options.spare_cells = spare_cells;
  options.spare_groups = spare_groups;
  return options;
}

}  // namespace

void EntryQueue::give(std::span<const std::uint8_t> block) {
  std::size_t at = 0;
  while (at < block.size()) {
    EntryHeader header;
    if (block.size() - at < sizeof header) throw std::invalid_argument("recording: a block ends within an entry");
    std::memcpy(&header, block.data() + at, sizeof header);
    if (header.bytes > block.size() || block.size() - at < entry_bytes(header.bytes)) {
      throw std::invalid_argument("recording: an entry of " + std::to_string(header.bytes) + " bytes passes its block");
    }
    if (header.time_ns <= -time_limit_ns || header.time_ns >= time_limit_ns) {
      throw std::invalid_argument("recording: an entry has an impossible time");
    }
    at += entry_bytes(header.bytes);
  }
  if (at_ > bytes_.size() / 2) {
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(at_));
    at_ = 0;
  }
  if (bytes_.size() + block.size() > queue_limit_bytes) {
    throw std::invalid_argument("recording: more than 1 GiB of entries wait for a read that never comes");
  }
  bytes_.insert(bytes_.end(), block.begin(), block.end());
}

std::optional<EntryQueue::View> EntryQueue::front() const {
  if (at_ == bytes_.size()) return std::nullopt;
  const EntryHeader header = header_at(bytes_, at_);
  return View{static_cast<Entry>(header.kind),
              header.time_ns,
              {bytes_.data() + at_ + sizeof header, std::size_t{header.bytes}},
              header.flags};
}

void EntryQueue::pop() {
  at_ += entry_bytes(header_at(bytes_, at_).bytes);
}

void EntryQueue::clear() {
  bytes_.clear();
  at_ = 0;
}

Player::Player(const skin::SkinModel& model, std::size_t spare_cells, std::size_t spare_groups)
    : driver_(options_of(model, spare_cells, spare_groups)), reader_(driver_.samples(), model) {}

// Takes what the driver's thread wrote up to a publication; false if it is not all there yet. Without a keyframe before
// it nothing can be known, and the publication is passed over.
bool Player::reach(std::uint64_t publication) {
  while (driver_.samples().publications() < publication || !driver_known_) {
    const std::optional<EntryQueue::View> entry = driver_entries_.front();
    if (!entry) return false;
    switch (entry->kind) {
      case Entry::gap:
        gaps_ += number_of(*entry);
        driver_known_ = reader_known_ = false;
        break;
      case Entry::datagram:
        if (driver_known_) driver_.replay(entry->payload, entry->time_ns);
        break;
      case Entry::publication:
        if (!driver_known_) break;
        if (number_of(*entry) != driver_.samples().publications() + 1) {
          throw std::invalid_argument("recording: publication " + std::to_string(number_of(*entry)) + " follows " +
                                      std::to_string(driver_.samples().publications()));
        }
        driver_.publish(entry->time_ns);
        break;
      case Entry::keyframe:
        if (!driver_known_) {
          driver_.restore(entry->payload);
          driver_.publish(entry->time_ns);
          driver_known_ = true;
        }
        break;
      default:
        throw std::invalid_argument("recording: entry kind " + std::to_string(static_cast<unsigned>(entry->kind)) +
                                    " is none of the driver's");
    }
    driver_entries_.pop();
    if (driver_known_ && driver_.samples().publications() > publication) return true;
  }
  return true;
}

std::optional<std::int64_t> Player::advance(skin::SkinState& state) {
  while (const std::optional<EntryQueue::View> entry = control_entries_.front()) {
    const std::int64_t time_ns = entry->time_ns;
    switch (entry->kind) {
      case Entry::gap:
        gaps_ += number_of(*entry);
        reader_known_ = felt_known_ = false;
        break;
      case Entry::tare:
        if (number_of(*entry) == 0 || number_of(*entry) >= static_cast<std::uint64_t>(time_limit_ns)) {
          throw std::invalid_argument("recording: a tare of an impossible duration");
        }
        reader_.tare(static_cast<std::int64_t>(number_of(*entry)));
        break;
      case Entry::reader_keyframe:
        if (!reader_known_) {
          reader_.restore(entry->payload);
          reader_known_ = true;
        }
        break;
      case Entry::joints:
        take_doubles(entry->payload, joints_);
        break;
      case Entry::command:
        if (entry->payload.size() < sizeof command_mode_) throw std::invalid_argument("recording: a command cut short");
        std::memcpy(&command_mode_, entry->payload.data(), sizeof command_mode_);
        take_doubles(entry->payload.subspan(sizeof command_mode_), command_);
        command_by_clock_ = (entry->flags & ended_by_clock) != 0;
        break;
      case Entry::force_zero:
        break;
      case Entry::felt:
        felt_fresh_ns_ = take_felt(entry->payload, state);
        felt_force_.assign(state.normal_force.begin(), state.normal_force.end());
        felt_known_ = true;
        control_entries_.pop();
        return time_ns;
      case Entry::nothing_felt:
        if (!felt_known_) break;
        skin::distrust(time_ns, felt_fresh_ns_, state);
        control_entries_.pop();
        return time_ns;
      case Entry::read: {
        const std::uint64_t number = number_of(*entry);
        if (!reach(number)) return std::nullopt;
        control_entries_.pop();
        // After a gap, or where a seek fell between two keyframes, a read is passed over until all is known again.
        if (!reader_known_ || driver_.samples().publications() != number) {
          if (driver_.samples().publications() > number) reader_known_ = false;
          continue;
        }
        reader_.read(time_ns, state);
        return time_ns;
      }
      default:
        throw std::invalid_argument("recording: entry kind " + std::to_string(static_cast<unsigned>(entry->kind)) +
                                    " is none of the control thread's");
    }
    control_entries_.pop();
  }
  return std::nullopt;
}

void Player::seek() {
  driver_entries_.clear();
  control_entries_.clear();
  driver_known_ = reader_known_ = felt_known_ = false;
}

}  // namespace robotskin::record
