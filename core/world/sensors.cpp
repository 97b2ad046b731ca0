// SPDX-License-Identifier: Apache-2.0
#include "world/sensors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "skin/calibration.hpp"
#include "skin/proximity_curve.hpp"
#include "world/further_truth.hpp"
#include "world/random.hpp"

namespace robotskin::world {
namespace {

using skin::standard_gravity;

struct Channel {
  std::int32_t lowest, highest;
  double counts_per_unit;
};

#define CHANNEL(name, is_signed, bits, numerator, denominator, unit)                                         \
  Channel{(is_signed) ? -(1 << ((bits) - 1)) : 0, (is_signed) ? (1 << ((bits) - 1)) - 1 : (1 << (bits)) - 1, \
          static_cast<double>(denominator) / (numerator)},
constexpr Channel channels[RS_CHANNEL_ALL_COUNT] = {RS_ALL_CHANNELS(CHANNEL)};
#undef CHANNEL

enum Purpose : std::uint64_t { purpose_individual = 1, purpose_noise = 2, purpose_phase = 3, purpose_strange = 4 };

constexpr double full_scale_g = 2;
constexpr double reference_c = 25;  // of the accelerometer's zero
// Creep follows the load with this time constant; of its final size 1 - exp(-100 s / 40 s) is reached in 100 s.
constexpr double creep_lag_s = 40;
constexpr double creep_final_per_100_s = 1.0894;

// Counts that a channel would show, as a fault changes them; the noise comes later.
double faulty(const SensorFault& fault, int channel, double counts, double counts_per_unit, double time_s) {
  if (!fault.of(channel) || time_s < fault.begin_s) return counts;
  const double passed_s = time_s - fault.begin_s;
  switch (fault.kind) {
    case SensorFaultKind::drifting:
      return counts + fault.size * counts_per_unit * passed_s / 60;
    case SensorFaultKind::offset:
      return counts + fault.size * counts_per_unit;
    case SensorFaultKind::mis_scaled:
      return counts * fault.size;
    case SensorFaultKind::overheated:
      return counts + fault.size * counts_per_unit * (1 - std::exp(-passed_s / overheating_lag_s));
    case SensorFaultKind::end_of_range:
      return fault.size < 0 ? -1e9 : 1e9;
    default:
      return counts;
  }
}

bool is_force(int channel) {
  return channel >= RS_CHANNEL_force_1 && channel <= RS_CHANNEL_force_3;
}
bool is_acceleration(int channel) {
  return channel >= RS_CHANNEL_acceleration_x && channel <= RS_CHANNEL_acceleration_z;
}

}  // namespace

Sensors::Part Sensors::part_of(int channel) {
  if (channel == RS_CHANNEL_proximity) return part_proximity;
  if (is_force(channel)) return part_force;
  return is_acceleration(channel) ? part_acceleration : part_temperature;
}

Sensors::Sensors(std::size_t cells, const Imperfections& imperfections, std::uint64_t seed)
    : period_s_{imperfections.proximity_period_s, 0, imperfections.acceleration_period_s,
                imperfections.temperature_period_s},
      individuals_(cells),
      hysteresis_(imperfections.force_hysteresis),
      creep_(imperfections.force_creep * creep_final_per_100_s),
      strange_(cells) {
  draw_strangeness(imperfections, seed);
  for (int c = 0; c < RS_CHANNEL_COUNT; ++c) {
    double noise = imperfections.temperature_noise_c * channels[c].counts_per_unit;
    if (c == RS_CHANNEL_proximity) noise = imperfections.proximity_noise_counts;
    if (is_force(c)) noise = imperfections.force_noise_counts;
    if (is_acceleration(c)) noise = imperfections.acceleration_noise_g * channels[c].counts_per_unit;
    noise_counts_[c] = static_cast<float>(noise);
  }
  for (std::size_t i = 0; i < cells; ++i) {
    Individual& individual = individuals_[i];
    const std::uint64_t key = stream_key(seed, purpose_individual, i);
    for (int c = 0; c < RS_CHANNEL_COUNT; ++c) {
      double scale = 0, offset = imperfections.temperature_offset_c * channels[c].counts_per_unit, drift = 0, shift = 0;
      if (c == RS_CHANNEL_proximity) {
        scale = imperfections.proximity_scale;
        offset = imperfections.proximity_offset_counts;
        drift = imperfections.drift_counts;
      } else if (is_force(c)) {
        scale = imperfections.force_scale;
        shift = offset = imperfections.force_offset_counts;
        drift = 0.25 * imperfections.drift_counts;
      } else if (is_acceleration(c)) {
        scale = imperfections.acceleration_scale;
        offset = imperfections.acceleration_offset_g * channels[c].counts_per_unit;
      } else if (c == RS_CHANNEL_temperature_2) {
        drift = imperfections.drift_counts;
      }
      individual.scale[c] = static_cast<float>(1 + random_symmetric(key, 4 * c, scale));
      individual.offset_counts[c] = static_cast<float>(shift + random_symmetric(key, 4 * c + 1, offset));
      if (is_force(c))
        individual.offset_counts[c] += static_cast<float>(
            random_symmetric(key, 4 * c + 3, imperfections.force_offset_n * channels[c].counts_per_unit));
      individual.drift_counts[c] = static_cast<float>(drift);
      individual.drift_phase[c] = static_cast<float>(2 * std::numbers::pi * random_unit(key, 4 * c + 2));
    }
    const double period_s = imperfections.drift_period_s * std::exp2(random_symmetric(key, 1000, 1));
    individual.drift_rate = 2 * std::numbers::pi / period_s;
    individual.drift_now = {};
    individual.drift_step = -1;
    individual.noise_key = stream_key(seed, purpose_noise, i);
    individual.draws = 0;
    const std::uint64_t phase_key = stream_key(seed, purpose_phase, i);
    for (int p = 0; p < part_count; ++p) individual.part_phase[p] = static_cast<float>(random_unit(phase_key, p));
    individual.part_period.fill(never);
    individual.held = {};
  }
}

void Sensors::draw_strangeness(const Imperfections& imperfections, std::uint64_t seed) {
  const double turn_rad = imperfections.acceleration_turn_deg * std::numbers::pi / 180;
  for (std::size_t i = 0; i < strange_.size(); ++i) {
    Strangeness& strange = strange_[i];
    const std::uint64_t key = stream_key(seed, purpose_strange, i);
    Vector3 turn;
    for (int a = 0; a < 3; ++a) {
      turn[a] = turn_rad * normal_quantiles()[random_bits(key, a) >> (64 - normal_bits)];
      strange.nonlinearity[a] = random_symmetric(key, 10 + a, imperfections.acceleration_nonlinearity);
      strange.per_kelvin_g[a] = random_symmetric(key, 20 + a, imperfections.acceleration_per_kelvin_g);
      // The skin was put on long ago: its pre-load has crept.
      strange.preload_n[a] = random_unit(key, 30 + a) * imperfections.force_preload_n;
      strange.shown_n[a] = strange.preload_n[a];
      strange.crept[a] = creep_ * strange.preload_n[a];
    }
    strange.proximity_power = 2 * (1 + random_symmetric(key, 40, imperfections.proximity_exponent));
    // The cell's axes as the turned part sees them, then what each axis takes from the other two.
    const Matrix3 seen = rotation_about(-1 * turn);
    Matrix3 cross_axis{1, 0, 0, 0, 1, 0, 0, 0, 1};
    for (int k = 0; k < 9; ++k)
      if (k % 4 != 0) cross_axis[k] = random_symmetric(key, 50 + k, imperfections.acceleration_cross_axis);
    strange.acceleration = multiply(cross_axis, seen);
    strange.force = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    for (int k = 0; k < 9; ++k)
      if (k % 4 != 0) strange.force[k] = random_symmetric(key, 60 + k, imperfections.force_cross_sensor);
  }
}

double Sensors::proximity(const Strangeness& strange, const Truth& truth) const {
  if (truth.reflectance == 1 && strange.proximity_power == 2) return skin::proximity_from_distance(truth.distance_m);
  if (!(truth.distance_m <= skin::proximity_reach_m)) return 0;
  const double ratio = skin::proximity_cover_m / (skin::proximity_cover_m + std::max(truth.distance_m, 0.0));
  return truth.reflectance * std::pow(ratio, strange.proximity_power);
}

Vector3 Sensors::force(Strangeness& strange, const Truth& truth, double time_s) const {
  Vector3 felt;
  const Vector3 load = apply(strange.force, Vector3{truth.force_n[0], truth.force_n[1], truth.force_n[2]});
  const double share = std::min((time_s - strange.force_time_s) / creep_lag_s, 1.0);
  strange.force_time_s = time_s;
  for (int s = 0; s < 3; ++s) {
    const double load_n = std::max(load[s], 0.0) + strange.preload_n[s];
    // What is shown lags behind the load by half the width between the branches, either way.
    const double width_n = 0.5 * hysteresis_ * load_n;
    strange.shown_n[s] = std::clamp(strange.shown_n[s], load_n - width_n, load_n + width_n);
    strange.crept[s] += share * (creep_ * load_n - strange.crept[s]);
    felt[s] = strange.shown_n[s] + strange.crept[s];
  }
  return felt;
}

Vector3 Sensors::acceleration(const Strangeness& strange, const Truth& truth) const {
  Vector3 felt = apply(strange.acceleration, 1 / standard_gravity * truth.specific_force);
  for (int a = 0; a < 3; ++a)
    felt[a] += strange.nonlinearity[a] / full_scale_g * felt[a] * felt[a] +
               strange.per_kelvin_g[a] * (truth.board_temperature_c - reference_c);
  return felt;
}

// Which of its periods a part is in, counted from the start; `never` if it has none.
std::int64_t Sensors::period(const Individual& individual, Part part, double time_s) const {
  if (!(period_s_[part] > 0)) return never;
  return static_cast<std::int64_t>(std::floor(time_s / period_s_[part] + individual.part_phase[part]));
}

bool Sensors::measures_proximity(std::size_t cell, double time_s) const {
  const std::int64_t now = period(individuals_[cell], part_proximity, time_s);
  return now == never || now != individuals_[cell].part_period[part_proximity];
}

void Sensors::set_fault(std::size_t cell, const SensorFault& fault) {
  if (cell >= individuals_.size()) throw std::out_of_range("sensor fault: no cell " + std::to_string(cell));
  if (faults_.empty()) faults_.resize(individuals_.size());
  faults_[cell] = fault;
}

void Sensors::drift(Individual& individual, double time_s) const {
  const auto step = static_cast<std::int64_t>(time_s * 10);
  if (step == individual.drift_step) return;
  individual.drift_step = step;
  for (int c = 0; c < RS_CHANNEL_COUNT; ++c) {
    if (individual.drift_counts[c] == 0) continue;
    const double angle = individual.drift_rate * 0.1 * static_cast<double>(step) + individual.drift_phase[c];
    individual.drift_now[c] = individual.drift_counts[c] * static_cast<float>(std::sin(angle));
  }
}

bool Sensors::sample(std::size_t cell, double time_s, const Truth& truth, rs_sample& sample) {
  Individual& individual = individuals_[cell];
  drift(individual, time_s);
  std::array<double, RS_CHANNEL_COUNT> value;  // in the channel's unit
  Strangeness& strange = strange_[cell];
  const SensorFault* const fault = this->fault(cell);
  Truth felt = truth;
  if (fault != nullptr && fault->acts(SensorFaultKind::loose, time_s))
    felt.specific_force = apply(fault->turn, truth.specific_force);
  const Vector3 force_n = force(strange, truth, time_s), acceleration_g = acceleration(strange, felt);
  value[RS_CHANNEL_proximity] = proximity(strange, truth);
  for (int s = 0; s < 3; ++s) {
    value[RS_CHANNEL_force_1 + s] = force_n[s];
    value[RS_CHANNEL_acceleration_x + s] = acceleration_g[s];
  }
  value[RS_CHANNEL_temperature_1] = truth.board_temperature_c;
  value[RS_CHANNEL_temperature_2] = truth.surface_temperature_c;

  const auto& quantiles = normal_quantiles();
  std::uint64_t bits = random_bits(individual.noise_key, individual.draws++);
  std::array<bool, part_count> measures;
  for (int p = 0; p < part_count; ++p) {
    const std::int64_t now = period(individual, static_cast<Part>(p), time_s);
    measures[p] = now == never || now != individual.part_period[p];
    individual.part_period[p] = now;
  }
  bool saturated = false;
  for (int c = 0; c < RS_CHANNEL_COUNT; ++c) {
    if (c == 5) bits = random_bits(individual.noise_key, individual.draws++);  // 5 draws of 12 bits a word
    float noise = noise_counts_[c] * quantiles[bits & ((1U << normal_bits) - 1)];
    bool stays = false;
    if (fault != nullptr && fault->of(c)) {
      if (fault->acts(SensorFaultKind::noisy, time_s)) noise *= static_cast<float>(fault->size);
      stays = fault->acts(SensorFaultKind::stuck, time_s);
    }
    bits >>= normal_bits;
    const auto [lowest, highest, _] = channels[c];
    std::int32_t& held = individual.held[c];
    if (measures[part_of(c)] && !stays) {
      double counts = value[c] * channels[c].counts_per_unit * individual.scale[c] + individual.offset_counts[c] +
                      individual.drift_now[c];
      if (fault != nullptr) counts = faulty(*fault, c, counts, channels[c].counts_per_unit, time_s);
      const double limited = std::clamp(counts + noise, static_cast<double>(lowest), static_cast<double>(highest));
      held = static_cast<std::int32_t>(std::lrint(limited));
    }
    sample.value[c] = held;
    saturated |= held == highest || (lowest < 0 && held == lowest);
  }
  std::fill(sample.value + RS_CHANNEL_COUNT, sample.value + RS_CHANNEL_ALL_COUNT, 0);
#define ROBOTSKIN_FEEL(name, what, noise_in_unit)                                                                \
  {                                                                                                              \
    const auto [lowest, highest, counts_per_unit] = channels[RS_CHANNEL_##name];                                 \
    const double noise = quantiles[random_bits(individual.noise_key, individual.draws++) >> (64 - normal_bits)]; \
    const double counts = ((what) + (noise_in_unit) * noise) * counts_per_unit;                                  \
    const double limited = std::clamp(counts, static_cast<double>(lowest), static_cast<double>(highest));        \
    sample.value[RS_CHANNEL_##name] = static_cast<std::int32_t>(std::lrint(limited));                            \
  }
  RS_FURTHER_TRUTH(ROBOTSKIN_FEEL)
#undef ROBOTSKIN_FEEL
  samples_.fetch_add(1, std::memory_order_relaxed);
  if (saturated) saturated_.fetch_add(1, std::memory_order_relaxed);
  return saturated;
}

}  // namespace robotskin::world
