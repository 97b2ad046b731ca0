// SPDX-License-Identifier: Apache-2.0
// Where host-built cells get their readings.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "robotskin/channels.h"

namespace robotskin::serial {

class CellSensors {
 public:
  virtual ~CellSensors() = default;
  // The reading of `cell`, in counts; true if a sensor is missing or at the end of its range (as rs_board_sense).
  virtual bool sense(std::size_t cell, rs_sample& sample) = 0;
};

// Readings that another thread sets: a Python plug-in, a simulated body. A cell is faulty until its first one.
class SetSensors : public CellSensors {
 public:
  explicit SetSensors(std::size_t cells) : cells_(cells) {}
  SetSensors(const SetSensors&) = delete;
  SetSensors& operator=(const SetSensors&) = delete;

  bool sense(std::size_t cell, rs_sample& sample) override;
  // One thread may set a cell at a time; that of the cells never waits for it.
  void set(std::size_t cell, std::span<const std::int32_t, RS_CHANNEL_COUNT> counts, bool fault);
  std::size_t cell_count() const { return cells_.size(); }

 private:
  struct Reading {
    std::atomic<std::uint32_t> version{0};  // odd: it is being written
    std::array<std::atomic<std::int32_t>, RS_CHANNEL_COUNT> counts{};
    std::atomic<bool> fault{true};
    rs_sample last{};  // of the reader
    bool last_fault = true;
  };
  std::vector<Reading> cells_;
};

// A shared library with a C function `bool rs_board_sense(rs_sample*)`, the one that a chip's board has (board.h).
class LibrarySensors : public CellSensors {
 public:
  // Throws SerialError for what cannot be loaded or has no such function.
  explicit LibrarySensors(const std::string& path);
  ~LibrarySensors() override;
  LibrarySensors(const LibrarySensors&) = delete;
  LibrarySensors& operator=(const LibrarySensors&) = delete;

  bool sense(std::size_t, rs_sample& sample) override { return function_(&sample); }

 private:
  void* library_ = nullptr;
  bool (*function_)(rs_sample*) = nullptr;
};

}  // namespace robotskin::serial
