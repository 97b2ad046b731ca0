// SPDX-License-Identifier: Apache-2.0
// What the guard counted, as an array.
#pragma once

#include <cstdint>
#include <span>

#include "bindings/arrays.hpp"
#include "robot/guard.hpp"

namespace robotskin::bindings {

inline auto counts_of(const robot::Guard& guard) {
  const auto& counts = guard.intervention_counts();
  return copy_of(std::span<const std::uint64_t>(counts), {robot::limit_count, counts.size() / robot::limit_count});
}

}  // namespace robotskin::bindings
