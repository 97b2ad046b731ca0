// SPDX-License-Identifier: Apache-2.0
// What may look on while a loop runs: called in its thread, so it must neither wait, lock nor allocate.
#pragma once

#include <cstdint>

namespace robotskin::loop {

class SkinLoop;

class LoopWitness {
 public:
  virtual ~LoopWitness() = default;

  // After a tick, when all that the loop shows is of that tick.
  virtual void ticked(std::int64_t now_ns, const SkinLoop& loop) noexcept = 0;
};

}  // namespace robotskin::loop
