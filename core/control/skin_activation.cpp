// SPDX-License-Identifier: Apache-2.0
#include "control/skin_activation.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "control/control_error.hpp"
#include "control/instruction_sets.hpp"

namespace robotskin::control {
namespace {

void check(const char* name, const std::vector<float>& values, std::size_t cells) {
  if (values.size() != cells)
    throw ControlError(std::string(name) + " has " + std::to_string(values.size()) + " values, the skin has " +
                       std::to_string(cells) + " cells");
  for (std::size_t i = 0; i < cells; ++i)
    if (!std::isfinite(values[i]) || values[i] < 0)
      throw ControlError(std::string(name) + " of cell " + std::to_string(i) + " is " + std::to_string(values[i]) +
                         ": it must be finite and not negative");
}

// A narrower step between silent and full would have no finite slope.
constexpr float narrowest = 1e-6F;

void check_order(const char* name, std::size_t cell, float silent, float full) {
  if (!(full - silent >= narrowest))
    throw ControlError(std::string(name) + " of cell " + std::to_string(cell) + " is " + std::to_string(full) +
                       ": it must be greater than where the channel is silent, " + std::to_string(silent) +
                       ", by 1e-6 or more");
}

// Numbers that are not negative are ordered as their bits are, and whole numbers are compared in vectors everywhere.
constexpr auto infinite = std::bit_cast<std::int32_t>(std::numeric_limits<float>::infinity());

inline float zero_if_no_number(float value) {
  const auto bits = std::bit_cast<std::int32_t>(value);
  return std::bit_cast<float>(bits > infinite ? 0 : bits);
}
inline float clamped(float value, float upper) {
  const std::int32_t bits = std::max(std::bit_cast<std::int32_t>(value), 0);
  return std::bit_cast<float>(std::min(bits, std::bit_cast<std::int32_t>(upper)));
}

inline float activated(float value, const Threshold& threshold) {
  const float x = clamped(value - threshold.silent, threshold.width);
  return value * (x * x) * (threshold.square + threshold.cube * x);
}

ROBOTSKIN_INSTRUCTION_SETS
void kernel(std::size_t cells, const float* __restrict force, const float* __restrict proximity,
            const std::uint8_t* __restrict health, const float* __restrict share, const float* __restrict force_weight,
            const float* __restrict proximity_weight, const Threshold force_threshold,
            const Threshold proximity_threshold, float* __restrict magnitude) {
  for (std::size_t i = 0; i < cells; ++i) {
    const float sum = force[3 * i] + force[3 * i + 1] + force[3 * i + 2];
    const float felt = clamped(zero_if_no_number(sum), largest_cell_force_n);
    const float near = clamped(zero_if_no_number(proximity[i]), 1.0F);
    const float asked =  // [Cheng19 eq. 14]
        force_weight[i] * activated(felt, force_threshold) + proximity_weight[i] * activated(near, proximity_threshold);
    magnitude[i] = asked * (health[i] == static_cast<std::uint8_t>(skin::Health::alive) ? share[i] : 0.0F);
  }
}

}  // namespace

SkinGains SkinGains::uniform(std::size_t cells, float force_weight, float proximity_weight, float force_silent,
                             float force_full, float proximity_silent, float proximity_full) {
  const auto all = [cells](float value) { return std::vector<float>(cells, value); };
  return {all(force_weight), all(proximity_weight), all(force_silent),
          all(force_full),   all(proximity_silent), all(proximity_full)};
}

SkinActivation::SkinActivation(const SkinGains& gains, std::size_t cells)
    : force_weight_(gains.force_weight.begin(), gains.force_weight.end()),
      proximity_weight_(gains.proximity_weight.begin(), gains.proximity_weight.end()) {
  check("force_weight", gains.force_weight, cells);
  check("proximity_weight", gains.proximity_weight, cells);
  check("force_silent", gains.force_silent, cells);
  check("force_full", gains.force_full, cells);
  check("proximity_silent", gains.proximity_silent, cells);
  check("proximity_full", gains.proximity_full, cells);
  for (std::size_t cell = 0; cell < cells; ++cell) {
    check_order("force_full", cell, gains.force_silent[cell], gains.force_full[cell]);
    check_order("proximity_full", cell, gains.proximity_silent[cell], gains.proximity_full[cell]);
    const Threshold force(gains.force_silent[cell], gains.force_full[cell]);
    const Threshold proximity(gains.proximity_silent[cell], gains.proximity_full[cell]);
    if (regions_.empty() || regions_.back().force != force || regions_.back().proximity != proximity)
      regions_.push_back({cell, 0, force, proximity});
    ++regions_.back().count;
  }
}

void SkinActivation::apply(const skin::SkinState& state, const float* share, float* magnitude) const noexcept {
  static_assert(sizeof(skin::Health) == 1 && sizeof(state.normal_force[0]) == 3 * sizeof(float));
  const float* force = state.normal_force.data()->data();
  const auto* health = reinterpret_cast<const std::uint8_t*>(state.health.data());
  for (const auto& [first, count, force_threshold, proximity_threshold] : regions_)
    kernel(count, force + 3 * first, &state.proximity[first], health + first, share + first, &force_weight_[first],
           &proximity_weight_[first], force_threshold, proximity_threshold, magnitude + first);
}

}  // namespace robotskin::control
