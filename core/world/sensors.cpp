#include "world/sensors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "skin/calibration.hpp"
#include "skin/proximity_curve.hpp"
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
constexpr Channel channels[RS_CHANNEL_COUNT] = {RS_CHANNELS(CHANNEL)};
#undef CHANNEL

enum Purpose : std::uint64_t { purpose_individual = 1, purpose_noise = 2, purpose_phase = 3 };

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
      individuals_(cells) {
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

// Which of its periods a part is in, counted from the start; `never` if it has none.
std::int64_t Sensors::period(const Individual& individual, Part part, double time_s) const {
  if (!(period_s_[part] > 0)) return never;
  return static_cast<std::int64_t>(std::floor(time_s / period_s_[part] + individual.part_phase[part]));
}

bool Sensors::measures_proximity(std::size_t cell, double time_s) const {
  const std::int64_t now = period(individuals_[cell], part_proximity, time_s);
  return now == never || now != individuals_[cell].part_period[part_proximity];
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
  value[RS_CHANNEL_proximity] = skin::proximity_from_distance(truth.distance_m);
  for (int s = 0; s < 3; ++s) {
    value[RS_CHANNEL_force_1 + s] = truth.force_n[s];
    value[RS_CHANNEL_acceleration_x + s] = truth.specific_force[s] / standard_gravity;
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
    const float noise = noise_counts_[c] * quantiles[bits & ((1U << normal_bits) - 1)];
    bits >>= normal_bits;
    const auto [lowest, highest, _] = channels[c];
    std::int32_t& held = individual.held[c];
    if (measures[part_of(c)]) {
      const double counts = value[c] * channels[c].counts_per_unit * individual.scale[c] + individual.offset_counts[c] +
                            individual.drift_now[c] + noise;
      const double limited = std::clamp(counts, static_cast<double>(lowest), static_cast<double>(highest));
      held = static_cast<std::int32_t>(std::lrint(limited));
    }
    sample.value[c] = held;
    saturated |= held == highest || (lowest < 0 && held == lowest);
  }
  samples_ += 1;
  saturated_ += saturated ? 1 : 0;
  return saturated;
}

}  // namespace robotskin::world
