// SPDX-License-Identifier: Apache-2.0
#include "record/sample_columns.hpp"

#include <algorithm>
#include <cstring>

#include "skin/calibration.hpp"

namespace robotskin::record {

SampleColumns::SampleColumns(const skin::SkinModel& model)
    : calibration_(model.force_calibration), zero_(model.size() + 1) {
  for (std::size_t i = 0; i < model.size(); ++i) {
    const std::size_t group = model.key[i] >> 16, id = model.key[i] & 0xffff;
    if (row_.size() <= group) row_.resize(group + 1);
    if (row_[group].size() <= id) row_[group].resize(id + 1, static_cast<std::uint32_t>(model.size()));
    row_[group][id] = static_cast<std::uint32_t>(i);
  }
}

void SampleColumns::set_zero(std::span<const float> force_offset) {
  if (force_offset.size() != 3 * (zero_.size() - 1)) return;
  std::memcpy(zero_.data(), force_offset.data(), force_offset.size_bytes());
}

void SampleColumns::clear() {
  key.clear();
  stamp_ns.clear();
#define ROBOTSKIN_CLEAR(name, is_signed, first, channels, column, blank, unit) column.clear();
  RS_SENSORS(ROBOTSKIN_CLEAR)
#undef ROBOTSKIN_CLEAR
  flags.clear();
}

void SampleColumns::add(const driver::Sample& sample) {
  key.push_back(sample.key);
  stamp_ns.push_back(sample.stamp_ns);
#define ROBOTSKIN_ADD(name, is_signed, first, channels, column, blank, unit) \
  skin::to_si(sample.name, RS_CHANNEL_##first, column.emplace_back());
  RS_SENSORS(ROBOTSKIN_ADD)
#undef ROBOTSKIN_ADD
  const std::size_t cell = row(sample.key);
  const std::array<float, 3>& zero = zero_[cell];
  std::array<float, 3>& force = normal_force.back();
  if (cell < calibration_.size()) force = calibration_[cell].force(force);
  for (std::size_t i = 0; i < 3; ++i) force[i] = std::max(0.0F, force[i] - zero[i]);
  flags.push_back((sample.event ? 1U : 0U) | (sample.fault ? 2U : 0U) | (sample.refresh ? 4U : 0U));
}

}  // namespace robotskin::record
