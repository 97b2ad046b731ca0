// SPDX-License-Identifier: Apache-2.0
// Runs a skin without faults until the loads of its cables stay as they are.
#pragma once

#include <cstdint>
#include <vector>

#include "campaign/fault_case.hpp"

namespace robotskin::campaign {

struct SettledCase {
  double seconds = 0;  // of virtual time
  std::int32_t depth = 0;
  std::vector<std::vector<std::uint32_t>> loads;  // cells on each cable, by unit and port
};

// `even`: cells on the fullest cable at which nothing is left to do; 0: that cannot be told from loads alone.
SettledCase settle(const FaultCase& skin, std::uint32_t even);

}  // namespace robotskin::campaign
