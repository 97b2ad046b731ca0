// The nine channels of every cell: from what is true at its place to the counts its firmware reads.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "robotskin/channels.h"
#include "world/imperfections.hpp"
#include "world/vector3.hpp"

namespace robotskin::world {

// What is true at one cell at one instant.
struct Truth {
  std::array<double, 3> force_n;  // what each force sensor feels
  double distance_m;              // to the nearest object, +infinity: none
  Vector3 specific_force;         // m/s^2, cell frame
  double surface_temperature_c, board_temperature_c;
};

class Sensors {
 public:
  Sensors(std::size_t cells, const Imperfections& imperfections, std::uint64_t seed);

  // Counts at `time_s`. Each call of a cell takes the next numbers of its own random sequence. True if a channel is at
  // the end of its range.
  bool sample(std::size_t cell, double time_s, const Truth& truth, rs_sample& sample);

  std::uint64_t samples() const { return samples_; }
  std::uint64_t saturated_samples() const { return saturated_; }

 private:
  struct Individual {
    std::array<float, RS_CHANNEL_COUNT> scale, offset_counts, drift_counts, drift_phase;
    double drift_rate;  // rad/s
    std::array<float, RS_CHANNEL_COUNT> drift_now;
    std::int64_t drift_step;  // which tenth of a second drift_now is of
    std::uint64_t noise_key, draws;
  };

  void drift(Individual& individual, double time_s) const;

  std::array<float, RS_CHANNEL_COUNT> noise_counts_;
  std::vector<Individual> individuals_;
  std::uint64_t samples_ = 0, saturated_ = 0;
};

}  // namespace robotskin::world
