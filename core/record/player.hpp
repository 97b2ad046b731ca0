// SPDX-License-Identifier: Apache-2.0
// Recorded blocks through the shipping driver and skin reader: the skin state of each read, equal to the byte. Of skins
// without our driver, the states themselves.
//
// Blocks of the driver's tape and of the control tape are given in the order in which they were written; `advance`
// goes on to the next read whose publication is there. Bytes of a file may be anything: what no recorder writes is
// refused with std::invalid_argument.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "driver/driver.hpp"
#include "record/tape.hpp"
#include "skin/skin_reader.hpp"

namespace robotskin::record {

// Bytes given in blocks, taken entry by entry.
class EntryQueue {
 public:
  struct View {
    Entry kind;
    std::int64_t time_ns;
    std::span<const std::uint8_t> payload;
    std::uint16_t flags;
  };

  // Throws std::invalid_argument unless the block is whole entries with sizes and times that can be.
  void give(std::span<const std::uint8_t> block);
  // The next entry, valid until the next `pop` or `give`.
  std::optional<View> front() const;
  void pop();
  void clear();

 private:
  std::vector<std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

class Player {
 public:
  // `model`: the cells of the recording; `spare_cells`, `spare_groups` as the recorded driver had.
  Player(const skin::SkinModel& model, std::size_t spare_cells, std::size_t spare_groups);

  void give_driver(std::span<const std::uint8_t> block) { driver_entries_.give(block); }
  void give_control(std::span<const std::uint8_t> block) { control_entries_.give(block); }

  // Goes on to the next read and fills `state`; its time on the host's clock, or nothing where more blocks are needed.
  std::optional<std::int64_t> advance(skin::SkinState& state);

  // Forgets all blocks given, to go on from the next keyframe in those to come.
  void seek();

  driver::Driver& driver() { return driver_; }
  const skin::SkinReader& reader() const { return reader_; }
  // (N, 3) newton before any zero is taken; of a skin without our driver, as the loop had it.
  const std::vector<std::array<float, 3>>& measured_force() const {
    return felt_known_ ? felt_force_ : reader_.measured_force();
  }
  const std::vector<double>& joints() const { return joints_; }    // 3 n: position, velocity, effort; empty: none yet
  const std::vector<double>& command() const { return command_; }  // n, of the tick before this read; empty: none yet
  std::uint64_t command_mode() const { return command_mode_; }
  bool command_by_clock() const { return command_by_clock_; }  // a clock ended the tick of that command
  std::uint64_t gaps() const { return gaps_; }                 // entries that the recorder had to drop

 private:
  bool reach(std::uint64_t publication);

  driver::Driver driver_;
  skin::SkinReader reader_;
  EntryQueue driver_entries_, control_entries_;
  std::vector<double> joints_, command_;
  std::uint64_t command_mode_ = 0, gaps_ = 0;
  bool command_by_clock_ = false;
  bool driver_known_ = false;  // a keyframe has been taken in, and no gap has come since
  bool reader_known_ = false;
  std::vector<std::array<float, 3>> felt_force_;
  std::int64_t felt_fresh_ns_ = 0;
  bool felt_known_ = false;  // a whole state of a skin without our driver has been taken in, and no gap has come since
};

}  // namespace robotskin::record
