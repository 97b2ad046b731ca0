// SPDX-License-Identifier: Apache-2.0
#include "control/map_skin_task.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "control/control_error.hpp"
#include "control/touch_wrench.hpp"

namespace robotskin::control {
namespace {

void check(const char* name, const std::vector<double>& values, std::size_t count) {
  if (values.size() != count)
    throw ControlError(std::string("map skin task: ") + name + " has " + std::to_string(values.size()) +
                       " values, this robot and skin ask for " + std::to_string(count));
  for (const double value : values)
    if (!std::isfinite(value)) throw ControlError(std::string("map skin task: a ") + name + " is not finite");
}

}  // namespace

MapSkinTask::MapSkinTask(std::size_t joint_count, std::size_t cell_count, const SkinGains& gains, SkinMap map,
                         double lever)
    : Task("map skin", joint_count, 1),
      activation_(gains, cell_count),
      map_(std::move(map)),
      lever_(lever),
      magnitude_(cell_count) {
  const std::size_t tiles = joint_count > 0 ? map_.posture.size() / joint_count : 0;
  if (tiles == 0) throw ControlError("map skin task: the map has no posture");
  check("posture", map_.posture, tiles * joint_count);
  check("weight", map_.weight, tiles * cell_count * joint_count);
  if (!(lever > 0) || !std::isfinite(lever))
    throw ControlError("map skin task: lever " + std::to_string(lever) + " must be finite and greater than 0");
  tile_share_.assign(tiles, 0.0);
  tile_share_[0] = 1;
}

void MapSkinTask::recall(std::span<const double> position) noexcept {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t tile = 0; tile < tile_share_.size(); ++tile) {
    double distance = 0;
    for (std::size_t i = 0; i < joint_count(); ++i) {
      const double gap = map_.posture[tile * joint_count() + i] - position[i];
      distance += gap * gap;
    }
    if (distance < least) {
      least = distance;
      nearest_ = tile;
    }
  }
}

void MapSkinTask::start(const TaskInput& input) noexcept {
  recall(input.position);
  std::ranges::fill(tile_share_, 0.0);
  tile_share_[nearest_] = 1;
}

bool MapSkinTask::update(const TaskInput& input) noexcept {
  if (input.skin.size() != magnitude_.size() || input.share.size() != magnitude_.size()) return false;
  recall(input.position);
  const double step = input.period_s / fade_s;
  double others = 0;
  for (std::size_t tile = 0; tile < tile_share_.size(); ++tile) {
    if (tile == nearest_) continue;
    tile_share_[tile] = std::max(tile_share_[tile] - step, 0.0);
    others += tile_share_[tile];
  }
  tile_share_[nearest_] = std::max(1 - others, 0.0);

  activation_.apply(input.skin, input.share.data(), magnitude_.data());
  const std::size_t joints = joint_count();
  std::ranges::fill(torque_, 0.0);
  double felt = 0;
  for (std::size_t cell = 0; cell < magnitude_.size(); ++cell) {
    if (magnitude_[cell] == 0) continue;
    felt += magnitude_[cell];
    for (std::size_t tile = 0; tile < tile_share_.size(); ++tile) {
      if (tile_share_[tile] == 0) continue;
      const double push = -lever_ * magnitude_[cell] * tile_share_[tile];
      const double* weight = &map_.weight[(tile * magnitude_.size() + cell) * joints];
      for (std::size_t i = 0; i < joints; ++i) torque_[i] += push * weight[i];
    }
  }
  row_count_ = felt > 0 ? 1 : 0;
  if (row_count_ > 0) {
    const double factor = touch_share(felt) / (lever_ * felt);
    for (std::size_t i = 0; i < joints; ++i) rows_[i] = factor * torque_[i];
  }
  return true;
}

}  // namespace robotskin::control
