// SPDX-License-Identifier: Apache-2.0
#include "serial/cell_sensors.hpp"

#include <dlfcn.h>

#include "serial/serial_error.hpp"

namespace robotskin::serial {

bool SetSensors::sense(std::size_t cell, rs_sample& sample) {
  Reading& reading = cells_[cell];
  const std::uint32_t before = reading.version.load(std::memory_order_acquire);
  rs_sample found{};
  for (std::size_t c = 0; c < RS_CHANNEL_COUNT; ++c) found.value[c] = reading.counts[c].load(std::memory_order_relaxed);
  const bool fault = reading.fault.load(std::memory_order_relaxed);
  std::atomic_thread_fence(std::memory_order_acquire);
  if (before % 2 == 0 && reading.version.load(std::memory_order_relaxed) == before) {
    reading.last = found;
    reading.last_fault = fault;
  }
  sample = reading.last;
  return reading.last_fault;
}

void SetSensors::set(std::size_t cell, std::span<const std::int32_t, RS_CHANNEL_COUNT> counts, bool fault) {
  Reading& reading = cells_.at(cell);
  const std::uint32_t version = reading.version.load(std::memory_order_relaxed);
  reading.version.store(version + 1, std::memory_order_relaxed);
  std::atomic_thread_fence(std::memory_order_release);
  for (std::size_t c = 0; c < RS_CHANNEL_COUNT; ++c) reading.counts[c].store(counts[c], std::memory_order_relaxed);
  reading.fault.store(fault, std::memory_order_relaxed);
  reading.version.store(version + 2, std::memory_order_release);
}

LibrarySensors::LibrarySensors(const std::string& path) : library_(dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL)) {
  if (library_ == nullptr) throw SerialError(std::string("sensors ") + dlerror());
  function_ = reinterpret_cast<bool (*)(rs_sample*)>(dlsym(library_, "rs_board_sense"));
  if (function_ == nullptr) {
    dlclose(library_);
    throw SerialError("sensors " + path +
                      ": has no function 'bool rs_board_sense(rs_sample*)' (firmware/chip/board.h)");
  }
}

LibrarySensors::~LibrarySensors() {
  dlclose(library_);
}

}  // namespace robotskin::serial
