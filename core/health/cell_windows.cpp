// SPDX-License-Identifier: Apache-2.0
#include "health/cell_windows.hpp"

#include <algorithm>
#include <cmath>

#include "skin/calibration.hpp"

namespace robotskin::health {
namespace {

// A reading within half a count of the end of its channel's range. The lower end of a channel without a sign is where
// nothing is felt.
bool at_end(std::size_t channel, float value) {
  const skin::ChannelScale& scale = skin::channel_scales[channel];
  const float counts = value / scale.si_step;
  return counts >= static_cast<float>(scale.highest) - 0.5F ||
         (scale.lowest < 0 && counts <= static_cast<float>(scale.lowest) + 0.5F);
}

}  // namespace

CellWindows::CellWindows(const skin::SkinModel& skin)
    : place_(skin.size()), rows_(skin.size()), done_(skin.size()), running_(skin.size()) {
  for (std::size_t cell = 0; cell < skin.size(); ++cell) {
    const auto& r = skin.link_from_cell_rotation[cell];
    place_[cell] = {static_cast<std::size_t>(skin.link[cell]),
                    {r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]},
                    skin.link_from_cell_translation[cell]};
  }
}

void CellWindows::take_sample(std::size_t cell, const Channels& value, const LinkMotion* motion,
                              std::int64_t stamp_ns) noexcept {
  Running& running = running_[cell];
  CellWindow& row = rows_[cell];
  const bool first = row.samples++ == 0;
  for (std::size_t c = 0; c < channel_count; ++c) {
    const float now = value[c];
    running.sum[c] += now;
    row.least[c] = first ? now : std::min(row.least[c], now);
    row.most[c] = first ? now : std::max(row.most[c], now);
    running.ends[c] += at_end(c, now) ? 1 : 0;
    if (running.seen >= 2) {
      const double second = now - 2.0 * running.last[c] + running.before[c];
      running.squared[c] += second * second;
      ++running.second[c];
    }
    if (running.seen == 0 || now != running.last[c]) {
      row.unchanged[c] = 0;
      running.changed_ns[c] = stamp_ns;
    } else {
      ++row.unchanged[c];
    }
    row.unchanged_s[c] = 1e-9F * static_cast<float>(stamp_ns - running.changed_ns[c]);
    running.before[c] = running.last[c];
    running.last[c] = now;
  }
  running.seen = std::min(running.seen + 1, 3U);
  if (motion == nullptr || !motion->known()) return;
  const Place& place = place_[cell];
  const LinkForce& link = motion->link(place.link);
  std::array<double, 3> at{};
  for (std::size_t i = 0; i < 3; ++i)
    at[i] = link.origin[i] + link.gradient[3 * i] * place.position[0] + link.gradient[3 * i + 1] * place.position[1] +
            link.gradient[3 * i + 2] * place.position[2];
  for (std::size_t i = 0; i < 3; ++i)
    running.expected[i] += place.cell_from_link[3 * i] * at[0] + place.cell_from_link[3 * i + 1] * at[1] +
                           place.cell_from_link[3 * i + 2] * at[2];
  ++running.expected_count;
}

void CellWindows::add(const skin::SkinState& state, std::span<const std::array<float, 3>> measured_force,
                      const LinkMotion* motion, std::int64_t now_ns) noexcept {
  if (state.size() != rows_.size()) return;
  if (ticks_++ == 0) begun_ns_ = now_ns;
  newest_ns_ = now_ns;
  const bool measured = measured_force.size() == rows_.size();
  for (std::size_t cell = 0; cell < rows_.size(); ++cell) {
    const skin::Health health = state.health[cell];
    if (health == skin::Health::stuck) {
      ++rows_[cell].stuck;
    } else if (health != skin::Health::alive) {
      ++rows_[cell].silent;
      continue;
    }
    if (state.stamp_ns[cell] == running_[cell].stamp_ns) continue;
    running_[cell].stamp_ns = state.stamp_ns[cell];
    const std::array<float, 3>& force = measured ? measured_force[cell] : state.normal_force[cell];
    const std::array<float, 3>& felt = state.acceleration[cell];
    const std::array<float, 2>& celsius = state.temperature[cell];
    take_sample(
        cell, {state.proximity[cell], force[0], force[1], force[2], felt[0], felt[1], felt[2], celsius[0], celsius[1]},
        motion, state.stamp_ns[cell]);
  }
}

std::span<const CellWindow> CellWindows::take() {
  for (std::size_t cell = 0; cell < rows_.size(); ++cell) {
    CellWindow& row = rows_[cell];
    Running& running = running_[cell];
    for (std::size_t c = 0; c < channel_count; ++c) {
      const double count = std::max(row.samples, 1U);
      row.mean[c] = static_cast<float>(running.sum[c] / count);
      row.at_end[c] = static_cast<float>(running.ends[c] / count);
      // Of white noise a second difference has six times the variance.
      row.noise[c] =
          running.second[c] > 0 ? static_cast<float>(std::sqrt(running.squared[c] / (6.0 * running.second[c]))) : 0;
    }
    for (std::size_t i = 0; i < 3; ++i)
      row.expected[i] = running.expected_count > 0 ? static_cast<float>(running.expected[i] / running.expected_count)
                                                   : std::numeric_limits<float>::quiet_NaN();
    done_[cell] = row;
    const auto unchanged = row.unchanged;
    const auto unchanged_s = row.unchanged_s;
    row = CellWindow{};
    row.unchanged = unchanged;
    row.unchanged_s = unchanged_s;
    running.sum.fill(0);
    running.squared.fill(0);
    running.second.fill(0);
    running.ends.fill(0);
    running.expected.fill(0);
    running.expected_count = 0;
  }
  ticks_ = 0;
  return done_;
}

}  // namespace robotskin::health
