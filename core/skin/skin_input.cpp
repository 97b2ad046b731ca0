// SPDX-License-Identifier: Apache-2.0
#include "skin/skin_input.hpp"

#include <algorithm>
#include <limits>

namespace robotskin::skin {

void distrust(std::int64_t now_ns, std::int64_t fresh_ns, SkinState& state) noexcept {
  constexpr float most = std::numeric_limits<float>::max();
  const auto possible = [](float value) { return value >= 0 && value <= most; };  // false for what is no number
  const bool pressed = state.has(Sensor::force), near = state.has(Sensor::proximity);
  for (std::size_t cell = 0; cell < state.size(); ++cell) {
    if (state.health[cell] != Health::alive) continue;
    const auto& force = state.normal_force[cell];
    const bool forces = !pressed || (possible(force[0]) && possible(force[1]) && possible(force[2]));
    if (!forces || (near && !possible(state.proximity[cell])))
      state.health[cell] = Health::stuck;
    else if (state.stamp_ns[cell] > now_ns + sample_ahead_ns || state.stamp_ns[cell] < now_ns - fresh_ns)
      state.health[cell] = Health::stale;
  }
  state.time_ns = std::min(state.time_ns, now_ns);
}

}  // namespace robotskin::skin
