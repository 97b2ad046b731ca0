// SPDX-License-Identifier: Apache-2.0
// What a recording takes down while a robot works: two tapes, one of the driver's thread, one of the control thread.
//
// in   datagrams as they are accepted, publications, samples; reads and tares of the skin reader; joints and commands
//      of a skin without our driver: skin states
// out  blocks of tape entries, drained by other threads or processes
// bad  a full tape: entries are dropped and counted, and a keyframe is asked for, from which replay goes on
#pragma once

#include <atomic>
#include <cstdint>
#include <span>

#include "driver/driver.hpp"
#include "record/tape.hpp"
#include "skin/skin_reader.hpp"

namespace robotskin::record {

// In place of a command mode: joints have their own.
inline constexpr std::uint64_t modes_differ = 3;

class DriverTape final : public driver::Witness {
 public:
  // A keyframe follows the last one within so much of the recording's own time, which in a simulation passes faster or
  // slower than the host's.
  static constexpr std::int64_t keyframe_period_ns = 5'000'000'000;

  explicit DriverTape(std::span<std::uint8_t> memory) : tape_(memory, true) {}

  void accepted(std::span<const std::uint8_t> datagram, std::int64_t now_ns) noexcept override;
  void sampled(const driver::Sample& sample) noexcept override;
  void published(const driver::Driver& driver, std::uint64_t number, std::int64_t now_ns) noexcept override;

  // Any thread: the next publication is followed by a keyframe.
  void ask_for_keyframe() { keyframe_due_.store(true, std::memory_order_release); }
  // The publication of the last keyframe; 0: none yet.
  std::uint64_t keyframe_publication() const { return keyframe_publication_.load(std::memory_order_acquire); }

  Tape& tape() { return tape_; }
  const Tape& tape() const { return tape_; }

 private:
  Tape tape_;
  std::atomic<bool> keyframe_due_{true};
  std::int64_t keyframe_ns_ = 0;  // of the last one
  std::atomic<std::uint64_t> keyframe_publication_{0};
  void put(Entry kind, std::int64_t time_ns, std::span<const std::uint8_t> payload) noexcept {
    if (!tape_.put(kind, time_ns, payload)) lost_ = true;
  }

  bool lost_ = false;  // nothing but a keyframe helps a reader on
};

class ControlTape final : public skin::ReadWitness {
 public:
  // Reads are taken down from the first one on that sees a keyframe of `driver`.
  ControlTape(std::span<std::uint8_t> memory, DriverTape& driver) : tape_(memory, true), driver_(driver) {}

  void reading(const skin::SkinReader& reader, std::uint64_t number, std::int64_t now_ns) noexcept override;
  void taring(std::int64_t duration_ns) noexcept override;
  void zeroed(std::span<const std::array<float, 3>> force_offset, std::int64_t now_ns) noexcept override;

  // Of a skin without our driver: what a tick felt, and how old its samples may be; or that nothing was new.
  void felt(const skin::SkinState& state, std::int64_t fresh_ns, std::int64_t now_ns) noexcept;
  void nothing_felt(std::int64_t now_ns) noexcept;

  // (n) rad or m, rad/s or m/s, Nm or N, of the robot at `stamp_ns`.
  void joints(std::int64_t stamp_ns, std::span<const double> position, std::span<const double> velocity,
              std::span<const double> effort) noexcept;
  // What was sent to the robot at `now_ns`: a command mode by its number, or `modes_differ`, and its n values; whether
  // a clock ended the fusion that it came from.
  void command(std::int64_t now_ns, std::uint64_t mode, std::span<const double> values, bool by_clock) noexcept;

  Tape& tape() { return tape_; }
  const Tape& tape() const { return tape_; }

 private:
  Tape tape_;
  DriverTape& driver_;
  void put(Entry kind, std::int64_t time_ns, std::span<const std::span<const std::uint8_t>> parts,
           std::uint16_t flags = 0) noexcept {
    if (!tape_.put(kind, time_ns, parts, flags)) driver_.ask_for_keyframe();
  }

  std::uint64_t keyframe_ = 0;  // publication of the driver's keyframe that the last reader keyframe follows
  std::int64_t tare_untold_ns_ = 0;
};

}  // namespace robotskin::record
