// SPDX-License-Identifier: Apache-2.0
// Runs a case under all checkers, finds a smaller case that breaks the same invariant, and sums up many.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "campaign/fault_case.hpp"
#include "campaign/invariants.hpp"

namespace robotskin::campaign {

struct CaseReport {
  std::uint64_t seed = 0;
  std::vector<Break> breaks;  // of each invariant the first few
  std::uint64_t break_count = 0;
  std::uint64_t log_hash = 0;
  std::uint64_t events = 0, samples_taken = 0, samples_delivered = 0;
  std::uint64_t events_repeated = 0;                 // sent again, and marked so
  std::uint64_t crowded_out_most = 0;                // samples that found no room after one fault, in trees within load
  std::uint64_t lost_overloaded = 0;                 // samples of trees that had more than their cables carry
  std::uint64_t excused = 0;                         // samples that were false after memory was damaged
  std::uint64_t torque_sums = 0, torque_epochs = 0;  // at the host; epochs that had to be complete
  std::uint64_t frames_planted = 0;                  // forged, or played again
  double simulated_s = 0;
  double longest_repair_ms = 0, longest_wait_ms = 0, largest_control_share = 0;
};

CaseReport run_case(const FaultCase& drawn);

// The smallest case found that still breaks `invariant`: first without faults one by one, then without cells.
FaultCase shrink(const FaultCase& original, Invariant invariant, int runs_max = 200);

}  // namespace robotskin::campaign
