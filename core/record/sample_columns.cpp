// SPDX-License-Identifier: Apache-2.0
#include "record/sample_columns.hpp"

#include <algorithm>
#include <cstring>

#include "skin/calibration.hpp"

namespace robotskin::record {

SampleColumns::SampleColumns(std::span<const driver::CellKey> keys) : zero_(keys.size() + 1) {
  row_.reserve(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) row_.emplace(keys[i], static_cast<std::uint32_t>(i));
}

void SampleColumns::set_zero(std::span<const float> force_offset) {
  if (force_offset.size() != 3 * (zero_.size() - 1)) return;
  std::memcpy(zero_.data(), force_offset.data(), force_offset.size_bytes());
}

void SampleColumns::clear() {
  key.clear();
  stamp_ns.clear();
  normal_force.clear();
  proximity.clear();
  acceleration.clear();
  temperature.clear();
  flags.clear();
}

void SampleColumns::add(const driver::Sample& sample) {
  constexpr auto force_step = static_cast<float>(skin::force_1_step);
  constexpr auto acceleration_step = static_cast<float>(skin::acceleration_x_step * skin::standard_gravity);
  const auto found = row_.find(sample.key);
  const std::array<float, 3>& zero = zero_[found == row_.end() ? zero_.size() - 1 : found->second];
  key.push_back(sample.key);
  stamp_ns.push_back(sample.stamp_ns);
  std::array<float, 3>& force = normal_force.emplace_back();
  std::array<float, 3>& specific_force = acceleration.emplace_back();
  for (std::size_t i = 0; i < 3; ++i) {
    force[i] = std::max(0.0F, static_cast<float>(sample.force[i]) * force_step - zero[i]);
    specific_force[i] = static_cast<float>(sample.acceleration[i]) * acceleration_step;
  }
  proximity.push_back(static_cast<float>(sample.proximity[0] * skin::proximity_step));
  temperature.push_back({static_cast<float>(sample.temperature[0] * skin::temperature_1_step),
                         static_cast<float>(sample.temperature[1] * skin::temperature_2_step)});
  flags.push_back((sample.event ? 1U : 0U) | (sample.fault ? 2U : 0U) | (sample.refresh ? 4U : 0U));
}

}  // namespace robotskin::record
