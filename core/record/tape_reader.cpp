// SPDX-License-Identifier: Apache-2.0
#include "record/tape_reader.hpp"

#include <cstring>

namespace robotskin::record {
namespace {

constexpr std::size_t block_bytes = std::size_t{1} << 22;

}  // namespace

TapeReader::TapeReader(std::span<std::uint8_t> driver, std::span<std::uint8_t> control, std::size_t reader,
                       const skin::SkinModel& model)
    : samples(model), driver_(driver, false), control_(control, false), reader_(reader) {}

std::span<const std::uint8_t> TapeReader::drain_driver() {
  drained_.clear();
  kept_.clear();
  samples.clear();
  driver_.drain(reader_, drained_, block_bytes);
  for (std::size_t at = 0; at < drained_.size();) {
    EntryHeader header;
    std::memcpy(&header, drained_.data() + at, sizeof header);
    const std::size_t bytes = entry_bytes(header.bytes);
    if (header.kind == static_cast<std::uint16_t>(Entry::sample)) {
      driver::Sample sample;
      std::memcpy(&sample, drained_.data() + at + sizeof header, sizeof sample);
      samples.add(sample);
    } else {
      const auto from = drained_.begin() + static_cast<std::ptrdiff_t>(at);
      kept_.insert(kept_.end(), from, from + static_cast<std::ptrdiff_t>(bytes));
    }
    at += bytes;
  }
  return kept_;
}

std::span<const std::uint8_t> TapeReader::drain_control() {
  drained_.clear();
  control_.drain(reader_, drained_, block_bytes);
  return drained_;
}

}  // namespace robotskin::record
