// SPDX-License-Identifier: Apache-2.0
// The nine channels of every cell: from what is true at its place to the counts its firmware reads.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <vector>

#include "model/spatial.hpp"
#include "robotskin/channels.h"
#include "world/imperfections.hpp"
#include "world/sensor_fault.hpp"

namespace robotskin::world {

// What is true at one cell at one instant.
struct Truth {
  std::array<double, 3> force_n;  // what each force sensor feels
  double distance_m;              // to what reflects most, +infinity: nothing
  double reflectance;             // of that
  Vector3 specific_force;         // m/s^2, cell frame
  double surface_temperature_c, board_temperature_c;
};

class Sensors {
 public:
  Sensors(std::size_t cells, const Imperfections& imperfections, std::uint64_t seed);

  // Counts that a reading at `time_s` finds. A sensor measures at the first reading of each of its periods and holds
  // the value until the next; each reading of a cell takes the next numbers of its own random sequence. True if a
  // channel is at the end of its range.
  bool sample(std::size_t cell, double time_s, const Truth& truth, rs_sample& sample);
  // Whether a reading at `time_s` would measure proximity anew; otherwise `Truth::distance_m` is not looked at.
  bool measures_proximity(std::size_t cell, double time_s) const;

  // What is wrong with a cell from now on; it replaces what was. Throws std::out_of_range for no cell.
  void set_fault(std::size_t cell, const SensorFault& fault);

  std::size_t cell_count() const { return individuals_.size(); }
  std::uint64_t samples() const { return samples_.load(std::memory_order_relaxed); }
  std::uint64_t saturated_samples() const { return saturated_.load(std::memory_order_relaxed); }

 private:
  // What measures on a clock of its own.
  enum Part : std::uint8_t { part_proximity, part_force, part_acceleration, part_temperature, part_count };
  static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::min();
  static Part part_of(int channel);

  struct Individual {
    std::array<float, RS_CHANNEL_COUNT> scale, offset_counts, drift_counts, drift_phase;
    double drift_rate;  // rad/s
    std::array<float, RS_CHANNEL_COUNT> drift_now;
    std::int64_t drift_step;  // which tenth of a second drift_now is of
    std::uint64_t noise_key, draws;
    std::array<float, part_count> part_phase;          // share of its period
    std::array<std::int64_t, part_count> part_period;  // which one the held values are of
    std::array<std::int32_t, RS_CHANNEL_COUNT> held;   // counts
  };

  // What differs by its kind from the models of the estimators, not only in its numbers; drawn if it is switched on.
  struct Strangeness {
    Matrix3 acceleration;                                 // what an axis shows of the cell's three
    Matrix3 force;                                        // what a force sensor shows of the cell's three
    Vector3 nonlinearity, per_kelvin_g;                   // of each axis
    double proximity_power;                               // 2 for the curve that the host inverts
    std::array<double, 3> preload_n, shown_n{}, crept{};  // of each force sensor; the last two are its memory
    double force_time_s = 0;                              // of the memory
  };

  void draw_strangeness(const Imperfections& imperfections, std::uint64_t seed);
  // What the parts make of the truth before noise, offset and scale; newton, g and share of full scale.
  double proximity(const Strangeness& strange, const Truth& truth) const;
  Vector3 force(Strangeness& strange, const Truth& truth, double time_s) const;
  Vector3 acceleration(const Strangeness& strange, const Truth& truth) const;
  std::int64_t period(const Individual& individual, Part part, double time_s) const;
  const SensorFault* fault(std::size_t cell) const { return faults_.empty() ? nullptr : &faults_[cell]; }
  void drift(Individual& individual, double time_s) const;

  std::array<float, RS_CHANNEL_COUNT> noise_counts_;
  std::array<double, part_count> period_s_;  // 0: measures at each reading
  std::vector<Individual> individuals_;
  double hysteresis_, creep_;
  std::vector<Strangeness> strange_;
  std::vector<SensorFault> faults_;                         // (N), or none at all
  std::atomic<std::uint64_t> samples_ = 0, saturated_ = 0;  // by whichever thread reads
};

}  // namespace robotskin::world
