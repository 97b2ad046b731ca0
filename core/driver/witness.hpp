// SPDX-License-Identifier: Apache-2.0
// What may look on while a driver works: called in the driver's thread, so it must neither wait, lock nor allocate.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "driver/sample.hpp"

namespace robotskin::driver {

class Driver;

class Witness {
 public:
  virtual ~Witness() = default;

  // A datagram that was accepted: its tag, session and sequence number are right.
  virtual void accepted(std::span<const std::uint8_t> datagram, std::int64_t now_ns) noexcept = 0;

  // A sample that is newer than all before it of its cell.
  virtual void sampled(const Sample& sample) noexcept = 0;

  // A publication; `number` counts them from 1.
  virtual void published(const Driver& driver, std::uint64_t number, std::int64_t now_ns) noexcept = 0;
};

}  // namespace robotskin::driver
