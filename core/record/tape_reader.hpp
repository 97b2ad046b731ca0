// SPDX-License-Identifier: Apache-2.0
// One reader of the two tapes of a recorder, in any thread of any process: entries as they are, and samples as columns.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "record/sample_columns.hpp"
#include "record/tape.hpp"

namespace robotskin::record {

class TapeReader {
 public:
  // Of the tapes in two pieces of memory that outlive it; of what model the samples are.
  TapeReader(std::span<std::uint8_t> driver, std::span<std::uint8_t> control, std::size_t reader,
             const skin::SkinModel& model);

  // The next entries of the driver's tape, at most some 4 MiB: those that are stored as they are, and `samples`.
  std::span<const std::uint8_t> drain_driver();
  // Those of the control thread's tape.
  std::span<const std::uint8_t> drain_control();

  // Of the last `drain_driver`.
  SampleColumns samples;

 private:
  Tape driver_, control_;
  std::size_t reader_;
  std::vector<std::uint8_t> drained_, kept_;  // of the last drain, kept for their memory
};

}  // namespace robotskin::record
