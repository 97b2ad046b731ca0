// SPDX-License-Identifier: Apache-2.0
#include "record/sample_columns.hpp"

#include <algorithm>
#include <cstring>

#include "skin/calibration.hpp"

namespace robotskin::record {

SampleColumns::SampleColumns(const skin::SkinModel& model)
    : calibration_(model.force_calibration), zero_(model.size() + 1) {
  row_.reserve(model.size());
  for (std::size_t i = 0; i < model.size(); ++i) row_.emplace(model.key[i], static_cast<std::uint32_t>(i));
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
  const auto found = row_.find(sample.key);
  const std::array<float, 3>& zero = zero_[found == row_.end() ? zero_.size() - 1 : found->second];
  std::array<float, 3>& force = normal_force.back();
  if (found != row_.end() && !calibration_.empty()) force = calibration_[found->second].force(force);
  for (std::size_t i = 0; i < 3; ++i) force[i] = std::max(0.0F, force[i] - zero[i]);
  flags.push_back((sample.event ? 1U : 0U) | (sample.fault ? 2U : 0U) | (sample.refresh ? 4U : 0U));
}

}  // namespace robotskin::record
