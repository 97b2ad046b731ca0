// SPDX-License-Identifier: Apache-2.0
#include "skin/foreign_input.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "skin/proximity_curve.hpp"

namespace robotskin::skin {

ForeignInput::ForeignInput(std::size_t cells, const ForeignOptions& options)
    : cells_(cells), options_(options), table_(cells), taken_(cells, 0), force_offset_(cells), sum_(cells) {
  if (cells == 0) throw std::invalid_argument("a skin has at least one cell");
  if (options.sensors == 0 || (options.sensors & ~all_sensors) != 0)
    throw std::invalid_argument("sensors: at least one of those that there are");
  if (options.fresh_ns <= 0) throw std::invalid_argument("fresh_s must be greater than 0");
  if (!(options.tare_limit_n >= 0)) throw std::invalid_argument("tare_limit_n must be 0 or more");
}

void ForeignInput::tare(std::int64_t duration_ns) {
  if (duration_ns <= 0) throw std::invalid_argument("a tare must last longer than 0 s");
  tare_ns_ = duration_ns;
  tare_end_ns_ = 0;
  std::fill(sum_.begin(), sum_.end(), Sum{});
}

void ForeignInput::finish_tare() noexcept {
  tare_refused_ = 0;
  for (std::size_t cell = 0; cell < cells_; ++cell) {
    bool refused = false;
    for (std::size_t i = 0; i < 3 && sum_[cell].count > 0; ++i) {
      const float offset = sum_[cell].force[i] / static_cast<float>(sum_[cell].count);
      const bool beyond = !(std::abs(offset) <= options_.tare_limit_n);
      force_offset_[cell][i] = beyond ? 0 : offset;
      refused = refused || beyond;
    }
    tare_refused_ += refused ? 1 : 0;
  }
  tare_ns_ = 0;
}

void ForeignInput::take(std::size_t cell, const ForeignSample& sample, SkinState& state) noexcept {
#define ROBOTSKIN_TAKE(name, is_signed, first, channels, column, blank, unit) \
  if (state.has(Sensor::name)) state.column[cell] = sample.column;
  RS_SENSORS(ROBOTSKIN_TAKE)
#undef ROBOTSKIN_TAKE
  if (state.has(Sensor::proximity))
    state.distance[cell] = static_cast<float>(distance_from_proximity(sample.proximity));
  if (state.has(Sensor::force)) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (taring()) sum_[cell].force[i] += sample.normal_force[i];
      // What is no number must stay none, so that it is seen.
      float& force = state.normal_force[cell][i];
      force -= force_offset_[cell][i];
      if (force < 0) force = 0;
    }
    if (taring()) ++sum_[cell].count;
  }
  state.saturated[cell] = sample.saturated ? 1 : 0;
  state.stamp_ns[cell] = sample.stamp_ns;
  state.health[cell] = Health::alive;
}

InputStatus ForeignInput::read(std::int64_t now_ns, SkinState& state) noexcept {
  if (state.size() != cells_) return InputStatus::disconnected;
  const auto samples = table_.read();
  if (taring() && tare_end_ns_ == 0) tare_end_ns_ = now_ns + tare_ns_;
  if (taring() && now_ns >= tare_end_ns_) finish_tare();
  if (table_.publication() == publication_)
    return ended_.load(std::memory_order_acquire) ? InputStatus::disconnected : InputStatus::nothing_new;
  publication_ = table_.publication();
  for (std::size_t cell = 0; cell < cells_; ++cell) {
    if (samples[cell].samples == taken_[cell]) continue;
    taken_[cell] = samples[cell].samples;
    take(cell, samples[cell], state);
  }
  state.time_ns = std::min(now_ns, table_.published_ns());
  return InputStatus::ok;
}

}  // namespace robotskin::skin
