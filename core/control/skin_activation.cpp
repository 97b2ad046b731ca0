#include "control/skin_activation.hpp"

#include <cmath>
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

std::vector<float> slopes(const char* name, const std::vector<float>& silent, const std::vector<float>& full) {
  std::vector<float> slope(silent.size());
  for (std::size_t i = 0; i < silent.size(); ++i) {
    if (!(full[i] > silent[i]))
      throw ControlError(std::string(name) + " of cell " + std::to_string(i) + " is " + std::to_string(full[i]) +
                         ": it must be greater than where the channel is silent, " + std::to_string(silent[i]));
    slope[i] = 1 / (full[i] - silent[i]);
  }
  return slope;
}

// Comparisons are ordered so that a value that is not a number becomes the lower bound.
inline float clamped(float value, float upper) {
  value = value > 0 ? value : 0;
  return value < upper ? value : upper;
}

inline float activated(float value, float silent, float slope) {
  const float x = clamped((value - silent) * slope, 1.0F);
  return value * x * x * (3 - 2 * x);
}

ROBOTSKIN_INSTRUCTION_SETS
void kernel(std::size_t cells, const float* __restrict force, const float* __restrict proximity,
            const std::uint8_t* __restrict health, const float* __restrict share, const float* __restrict force_weight,
            const float* __restrict force_silent, const float* __restrict force_slope,
            const float* __restrict proximity_weight, const float* __restrict proximity_silent,
            const float* __restrict proximity_slope, double* __restrict magnitude) {
  for (std::size_t i = 0; i < cells; ++i) {
    const float felt = clamped(force[3 * i] + force[3 * i + 1] + force[3 * i + 2], largest_cell_force_n);
    const float near = clamped(proximity[i], 1.0F);
    const float asked = force_weight[i] * activated(felt, force_silent[i], force_slope[i]) +
                        proximity_weight[i] * activated(near, proximity_silent[i], proximity_slope[i]);
    const float alive = share[i] * static_cast<float>(health[i] == static_cast<std::uint8_t>(skin::Health::alive));
    magnitude[i] = asked * alive;
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
    : force_weight_(gains.force_weight),
      proximity_weight_(gains.proximity_weight),
      force_silent_(gains.force_silent),
      proximity_silent_(gains.proximity_silent) {
  check("force_weight", gains.force_weight, cells);
  check("proximity_weight", gains.proximity_weight, cells);
  check("force_silent", gains.force_silent, cells);
  check("force_full", gains.force_full, cells);
  check("proximity_silent", gains.proximity_silent, cells);
  check("proximity_full", gains.proximity_full, cells);
  force_slope_ = slopes("force_full", gains.force_silent, gains.force_full);
  proximity_slope_ = slopes("proximity_full", gains.proximity_silent, gains.proximity_full);
}

void SkinActivation::apply(const skin::SkinState& state, const float* share, double* magnitude) const noexcept {
  static_assert(sizeof(skin::Health) == 1 && sizeof(state.normal_force[0]) == 3 * sizeof(float));
  kernel(cell_count(), state.normal_force.data()->data(), state.proximity.data(),
         reinterpret_cast<const std::uint8_t*>(state.health.data()), share, force_weight_.data(), force_silent_.data(),
         force_slope_.data(), proximity_weight_.data(), proximity_silent_.data(), proximity_slope_.data(), magnitude);
}

}  // namespace robotskin::control
