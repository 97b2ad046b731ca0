// SPDX-License-Identifier: Apache-2.0
#include "world/temperature.hpp"

#include <cmath>

namespace robotskin::world {
namespace {

constexpr double surface_lag_s = 2.6;  // the published time constant of the cell's thermometer
constexpr double board_lag_s = 10;     // the second thermometer lies on the board behind it

}  // namespace

Temperature::Temperature(const Mounting& mounting) : mounting_(mounting) {
  const double ambient_c = mounting.ambient_temperature;
  cells_.assign(mounting.cell_count(), {ambient_c, ambient_c, ambient_c, 0});
}

void Temperature::touch(std::size_t cell, int object, double time_s) {
  const double towards_c = object < 0 ? mounting_.ambient_temperature : mounting_.object_temperature[object];
  Cell& state = cells_[cell];
  if (towards_c == state.towards_c) return;
  const double surface_c = surface_temperature(cell, time_s), board_c = board_temperature(cell, time_s);
  state = {surface_c, board_c, towards_c, time_s};
}

double Temperature::surface_temperature(std::size_t cell, double time_s) const {
  const Cell& state = cells_[cell];
  if (state.surface_c == state.towards_c) return state.towards_c;
  return state.towards_c + (state.surface_c - state.towards_c) * std::exp((state.since_s - time_s) / surface_lag_s);
}

double Temperature::board_temperature(std::size_t cell, double time_s) const {
  const Cell& state = cells_[cell];
  if (state.board_c == state.towards_c) return state.towards_c;
  return state.towards_c + (state.board_c - state.towards_c) * std::exp((state.since_s - time_s) / board_lag_s);
}

}  // namespace robotskin::world
