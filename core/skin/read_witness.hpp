// SPDX-License-Identifier: Apache-2.0
// What may look on while the skin reader works: called in its thread, so it must neither wait, lock nor allocate.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace robotskin::skin {

class SkinReader;

class ReadWitness {
 public:
  virtual ~ReadWitness() = default;

  // Before a read at `now_ns` changes anything: it sees publication `number` of the driver.
  virtual void reading(const SkinReader& reader, std::uint64_t number, std::int64_t now_ns) noexcept = 0;

  // A tare was asked for: it begins with the next read.
  virtual void taring(std::int64_t duration_ns) noexcept = 0;

  // What is subtracted from each force from now on, (N, 3) newton.
  virtual void zeroed(std::span<const std::array<float, 3>> force_offset, std::int64_t now_ns) noexcept = 0;
};

}  // namespace robotskin::skin
