// SPDX-License-Identifier: Apache-2.0
// Bytes to and from the other end of one cable, by a descriptor that can be waited for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace robotskin::serial {

class Line {
 public:
  virtual ~Line() = default;

  virtual int descriptor() const = 0;  // -1: there is nothing now

  // Takes what has come; 0: nothing has, or the line is gone.
  virtual std::size_t read(std::span<std::uint8_t> bytes) = 0;

  // Whether all of them were taken; never waits.
  virtual bool write(std::span<const std::uint8_t> bytes) = 0;

  // Looks, now and then, whether a line that is gone has come back.
  virtual void tend(std::int64_t now_ns) = 0;

  // Times that the line was gone.
  virtual std::uint64_t pulled() const = 0;
};

}  // namespace robotskin::serial
