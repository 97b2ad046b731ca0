// SPDX-License-Identifier: Apache-2.0
// From what a cell senses to the one scalar force it asks for [Cheng19 eq. 14], with smooth activation.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "skin/skin_state.hpp"

namespace robotskin::control {

// Per cell; a region is a set of cells given the same numbers, and computed fastest where its cells follow each other.
// Below `silent` a channel contributes nothing, from `full` on all of it, between them a share that grows without a
// step or a kink.
struct SkinGains {
  std::vector<float> force_weight;      // (N) w_f, newton asked for a newton felt
  std::vector<float> proximity_weight;  // (N) w_p, newton asked for at full-scale proximity
  std::vector<float> force_silent;      // (N) newton, sum of the three sensors
  std::vector<float> force_full;        // (N) newton, greater than force_silent
  std::vector<float> proximity_silent;  // (N) 0 to 1
  std::vector<float> proximity_full;    // (N) 0 to 1, greater than proximity_silent

  // The same numbers for every cell.
  static SkinGains uniform(std::size_t cells, float force_weight, float proximity_weight, float force_silent,
                           float force_full, float proximity_silent, float proximity_full);

  // Weight 1 on force and none on proximity: the measured normal force as a torque.
  SkinGains measured_force() const {
    SkinGains gains = *this;
    gains.force_weight.assign(force_weight.size(), 1.0F);
    gains.proximity_weight.assign(proximity_weight.size(), 0.0F);
    return gains;
  }
};

// A cell's three sensors read 10 N each at most; more than this sum cannot be a touch and is cut.
inline constexpr float largest_cell_force_n = 30.0F;

// Of one channel: the share of a value is 0 below `silent`, 1 from `width` above it, and between them a smoothstep.
struct Threshold {
  Threshold(float silent_from, float full_from)
      : silent(silent_from),
        width(full_from - silent_from),
        square(3 / (width * width)),
        cube(-2 / (width * width * width)) {}

  float silent, width;
  float square, cube;  // smoothstep = square x^2 + cube x^3 of x above `silent`
  bool operator==(const Threshold&) const = default;
};

class SkinActivation {
 public:
  // Throws ControlError naming the gain whose count is not `cells`, or the cell where a value is not finite, negative
  // or out of order.
  SkinActivation(const SkinGains& gains, std::size_t cells);

  std::size_t cell_count() const noexcept { return force_weight_.size(); }

  // magnitude (N) newton: share * (w_f sum f + w_p p) along each cell's z axis, before the sign of touch. Zero for
  // every cell that is not alive. `share` (N) 0 to 1, masks a cell with 0. The state has N cells.
  void apply(const skin::SkinState& state, const float* share, float* magnitude) const noexcept;

 private:
  // Neighbouring cells of the same thresholds.
  struct Region {
    std::size_t first, count;
    Threshold force, proximity;
  };

  skin::CellArray<float> force_weight_, proximity_weight_;  // (N)
  std::vector<Region> regions_;                             // all cells, in their order
};

}  // namespace robotskin::control
