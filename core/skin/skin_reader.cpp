// SPDX-License-Identifier: Apache-2.0
#include "skin/skin_reader.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "skin/calibration.hpp"
#include "skin/proximity_curve.hpp"

namespace robotskin::skin {
namespace {

using driver::Sample;

constexpr float force_step_n = static_cast<float>(force_1_step);

// The thermometers' own ranges are narrower than their channels: beyond them a reading cannot be true.
constexpr double temperature_lowest_c = -45, temperature_highest_c = 130;

constexpr std::int64_t fresh_periods = 5;

// Whether a channel is within so many sixteenths of its range of an end. A signed channel has two ends; the lower one
// of the others is where nothing is felt.
bool near_end(const Sample& sample, int sixteenths) {
  bool any = false;
  const auto look = [&any, sixteenths](const auto& counts, std::size_t first) {
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const ChannelScale& scale = channel_scales[first + i];
      const int margin = (scale.highest - scale.lowest) / 16 * sixteenths;
      any |= counts[i] >= scale.highest - margin || (scale.lowest < 0 && counts[i] <= scale.lowest + margin);
    }
  };
#define ROBOTSKIN_LOOK(name, is_signed, first, ...) look(sample.name, RS_CHANNEL_##first);
  RS_SENSORS(ROBOTSKIN_LOOK)
#undef ROBOTSKIN_LOOK
  return any;
}

// A cell tells by one bit that a sensor is saturated or missing. A saturated one shows the end of its range, but for
// the offset that the cell adds; where none is near its end, one is missing.
bool saturated(const Sample& sample) {
  return near_end(sample, 0) || (sample.fault && near_end(sample, 1));
}
bool missing(const Sample& sample) {
  return sample.fault && !near_end(sample, 1);
}

// Further channels that have not come for so long are not known any more: at the slowest clock rate one of their frames
// may be lost, at the usual one seven.
constexpr std::int64_t further_fresh_ns = 1'100'000'000;

void blank_further(std::size_t cell, SkinState& state) {
  [[maybe_unused]] constexpr float unknown = std::numeric_limits<float>::quiet_NaN();
#define ROBOTSKIN_BLANK(name, is_signed, first, channels, column, blank, unit) \
  if (RS_CHANNEL_##first >= RS_CHANNEL_COUNT) state.column[cell] = filled<channels>(static_cast<float>(blank));
  RS_SENSORS(ROBOTSKIN_BLANK)
#undef ROBOTSKIN_BLANK
}

bool impossible(const Sample& sample) {
  const auto out = [](double celsius) { return celsius < temperature_lowest_c || celsius > temperature_highest_c; };
  return out(sample.temperature[0] * temperature_1_step) || out(sample.temperature[1] * temperature_2_step);
}

}  // namespace

SkinReader::SkinReader(driver::SnapshotTable<Sample>& samples, const SkinModel& model, const ReaderOptions& options)
    : samples_(samples),
      options_(options),
      cells_(model.size()),
      taken_(cells_, 0),
      cadence_(cells_),
      calibration_(model.force_calibration),
      force_offset_(cells_),
      measured_force_(cells_),
      sum_(cells_) {
  if (samples.size() < cells_) {
    throw std::invalid_argument("the model has " + std::to_string(cells_) + " cells, the driver only " +
                                std::to_string(samples.size()));
  }
  if (!calibration_.empty() && calibration_.size() != cells_) {
    throw std::invalid_argument("the calibration has " + std::to_string(calibration_.size()) + " cells, the model " +
                                std::to_string(cells_));
  }
}

std::array<float, 3> SkinReader::felt(std::size_t cell, const std::array<float, 3>& shown) const {
  return calibration_.empty() ? shown : calibration_[cell].force(shown);
}

void SkinReader::tare(std::int64_t duration_ns) {
  if (duration_ns <= 0) throw std::invalid_argument("a tare must last longer than 0 s");
  tare_ns_ = duration_ns;
  tare_end_ns_ = 0;
  std::fill(sum_.begin(), sum_.end(), Sum{});
  if (witness_ != nullptr) witness_->taring(duration_ns);
}

void SkinReader::finish_tare(std::int64_t now_ns) {
  tare_refused_ = 0;
  for (std::size_t cell = 0; cell < cells_; ++cell) {
    for (unsigned i = 0; i < 3 && sum_[cell].count > 0; ++i) {
      const float offset = sum_[cell].force[i] / static_cast<float>(sum_[cell].count);
      const bool refused = offset > options_.tare_limit_n;
      tare_refused_ += refused;
      force_offset_[cell][i] = refused ? 0 : offset;
    }
  }
  tare_ns_ = 0;
  std::fill(taken_.begin(), taken_.end(), 0U);  // convert everything again
  if (witness_ != nullptr) witness_->zeroed(force_offset_, now_ns);
}

// The time between a cell's samples, by their sequence numbers: loss on the way does not make it longer. After a
// silence longer than any period can be, nothing is known again.
void SkinReader::observe_period(std::size_t cell, const Sample& sample) {
  Cadence& cadence = cadence_[cell];
  const std::int64_t passed_ns = sample.stamp_ns - cadence.stamp_ns;
  const auto steps = static_cast<std::uint8_t>(sample.sequence - cadence.sequence);
  const std::uint8_t clock = sample.event ? 0 : 1;
  if (passed_ns > options_.event_fresh_ns || clock == 0 || cadence.clock == 0) {
    cadence.period_ns = 0;
  } else if (passed_ns > 0 && steps > 0) {
    cadence.period_ns = passed_ns / steps;
  }
  cadence.stamp_ns = sample.stamp_ns;
  cadence.sequence = sample.sequence;
  cadence.clock = clock;
}

std::int64_t SkinReader::fresh_ns(std::size_t cell, const Sample& sample) const {
  if (sample.event) return options_.event_fresh_ns;
  const std::int64_t longest_ns = std::max(options_.clock_fresh_ns, options_.event_fresh_ns);
  const std::int64_t least_ns = std::min(options_.clock_fresh_ns * std::max<int>(sample.rate_divisor, 1), longest_ns);
  return std::clamp(fresh_periods * cadence_[cell].period_ns, least_ns, longest_ns);
}

void SkinReader::take(std::size_t cell, const Sample& sample, SkinState& state) {
  if (taring()) {
    std::array<float, 3> shown;
    to_si(sample.force, RS_CHANNEL_force_1, shown);
    const std::array<float, 3> force = felt(cell, shown);
    for (unsigned i = 0; i < 3; ++i) sum_[cell].force[i] += force[i];
    ++sum_[cell].count;
  }
  convert(cell, sample, state);
}

void SkinReader::convert(std::size_t cell, const Sample& sample, SkinState& state) {
#define ROBOTSKIN_TO_SI(name, is_signed, first, channels, column, blank, unit) \
  to_si(sample.name, RS_CHANNEL_##first, state.column[cell]);
  RS_SENSORS(ROBOTSKIN_TO_SI)
  const std::int64_t fresh_ns = further_fresh_ns * std::max<int>(sample.rate_divisor, 1);
  if (driver::has_further_channels && sample.stamp_ns - driver::further_ns(sample) > fresh_ns)
    blank_further(cell, state);
#undef ROBOTSKIN_TO_SI
  measured_force_[cell] = state.normal_force[cell];
  const std::array<float, 3> force = felt(cell, measured_force_[cell]);
  for (unsigned i = 0; i < 3; ++i) state.normal_force[cell][i] = std::max(0.0F, force[i] - force_offset_[cell][i]);
  state.distance[cell] = static_cast<float>(distance_from_proximity(sample.proximity[0] * proximity_step));
  state.stamp_ns[cell] = sample.stamp_ns;
  state.saturated[cell] = saturated(sample);
}

bool SkinReader::anything_moves(std::span<const Sample> samples, std::int64_t now_ns) const {
  std::size_t seen = 0, moving = 0;
  for (const Sample& sample : samples.first(cells_)) {
    if (!sample.seen) continue;
    ++seen;
    moving += now_ns - sample.moved_ns < options_.moving_within_ns;
  }
  return moving * 2 > seen;
}

void SkinReader::read(std::int64_t now_ns, SkinState& state) {
  if (state.size() != cells_) {
    throw std::invalid_argument("the state has " + std::to_string(state.size()) + " cells, the model " +
                                std::to_string(cells_));
  }
  const std::span<const Sample> samples = samples_.read();
  if (witness_ != nullptr) witness_->reading(*this, samples_.publication(), now_ns);
  if (restored_) {
    restored_ = false;
    last_ = &state;
    for (std::size_t cell = 0; cell < cells_; ++cell) {
      if (taken_[cell] != 0) convert(cell, samples[cell], state);
    }
  } else if (&state != last_) {
    last_ = &state;
    std::fill(taken_.begin(), taken_.end(), 0U);
  }
  if (taring() && tare_end_ns_ == 0) {
    tare_end_ns_ = now_ns + tare_ns_;
    std::fill(taken_.begin(), taken_.end(), 0U);
  } else if (taring() && now_ns >= tare_end_ns_) {
    finish_tare(now_ns);
  }
  const bool others_move = anything_moves(samples, now_ns);
  for (std::size_t cell = 0; cell < cells_; ++cell) {
    const Sample& sample = samples[cell];
    if (!sample.seen) {
      state.health[cell] = sample.gone_ns != 0 ? Health::dead : Health::never_seen;
      continue;
    }
    const std::uint32_t frames = sample.clock_frames + sample.event_frames;
    if (taken_[cell] != frames) {
      taken_[cell] = frames;
      observe_period(cell, sample);
      take(cell, sample, state);
    }
    if (now_ns - sample.stamp_ns > fresh_ns(cell, sample)) {
      state.health[cell] = sample.gone_ns > sample.stamp_ns ? Health::dead : Health::stale;
    } else if (impossible(sample) || missing(sample) ||
               (others_move && now_ns - sample.moved_ns > options_.stuck_after_ns)) {
      state.health[cell] = Health::stuck;
    } else {
      state.health[cell] = Health::alive;
    }
  }
  // A driver that has stopped hands out no snapshot, and the guard sees the last one grow old.
  state.time_ns = std::min(now_ns, samples_.published_ns());
}

}  // namespace robotskin::skin
