// SPDX-License-Identifier: Apache-2.0
// Samples off a tape as columns in SI units, forces calibrated and less the zero of the last tare.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "driver/sample.hpp"
#include "skin/skin_model.hpp"
#include "skin/skin_state.hpp"

namespace robotskin::record {

class SampleColumns {
 public:
  explicit SampleColumns(const skin::SkinModel& model);

  // What is subtracted from each force from now on, (N, 3) newton; nothing happens for another number of cells.
  void set_zero(std::span<const float> force_offset);

  void clear();
  void add(const driver::Sample& sample);

  std::vector<std::uint32_t> key;      // (S) section-unit group << 16 | id
  std::vector<std::int64_t> stamp_ns;  // (S) host clock at the sample
  // A column of each sensor (channels.h), SI units.
#define ROBOTSKIN_COLUMN(name, is_signed, first, channels, column, blank, unit) \
  std::vector<skin::Column<channels>> column;
  RS_SENSORS(ROBOTSKIN_COLUMN)
#undef ROBOTSKIN_COLUMN
  std::vector<std::uint32_t> flags;  // (S) 1: an event, 2: a sensor's fault, 4: sent for freshness

 private:
  // The cell of a key; that behind the last one for a key outside the model.
  std::size_t row(driver::CellKey key) const {
    const std::size_t group = key >> 16, id = key & 0xffff;
    return group < row_.size() && id < row_[group].size() ? row_[group][id] : zero_.size() - 1;
  }

  std::vector<std::vector<std::uint32_t>> row_;      // by group and id
  std::vector<skin::ForceCalibration> calibration_;  // (N), or none
  std::vector<std::array<float, 3>> zero_;           // (N + 1, 3); the last row is of cells outside the model
};

}  // namespace robotskin::record
