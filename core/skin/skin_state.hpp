// SPDX-License-Identifier: Apache-2.0
// What the skin feels in one control cycle, in SI units.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "robotskin/channels.h"
#include "skin/cell_array.hpp"

namespace robotskin::skin {

// alive: fresh. stale: not heard of within the freshness bound. stuck: heard of, but its values cannot be true.
// dead: the network reports it gone. never_seen: not heard of since the driver started.
enum class Health : std::uint8_t { alive, stale, stuck, dead, never_seen };

// The sensors of channels.h, by their order there.
enum class Sensor : std::uint8_t {
#define ROBOTSKIN_SENSOR(name, is_signed, first, channels, column, blank, unit) name,
  RS_SENSORS(ROBOTSKIN_SENSOR)
#undef ROBOTSKIN_SENSOR
      count
};

// Which sensors a skin has, a bit each. Our own cells have all of them.
using SensorSet = std::uint32_t;
constexpr SensorSet only(Sensor sensor) {
  return SensorSet{1} << static_cast<unsigned>(sensor);
}
inline constexpr SensorSet all_sensors = only(Sensor::count) - 1;

// What a sensor of so many channels says of one cell.
template <std::size_t channels>
using Column = std::conditional_t<channels == 1, float, std::array<float, channels>>;

template <std::size_t channels>
Column<channels> filled(float value) {
  Column<channels> all{};
  if constexpr (channels == 1) {
    all = value;
  } else {
    all.fill(value);
  }
  return all;
}

// Struct of arrays, cell axis first, in the order of the SkinModel; sized once, filled every cycle.
// Values of a cell that is not alive are its last ones, of one never seen no touch, nothing near, temperature NaN:
// look at a cell's health before its values are used. Values of a sensor that the skin lacks are no numbers (NaN).
struct SkinState {
  // A column of each sensor (channels.h): the touch on the robot is -z times the sum of `normal_force`, `proximity` is
  // a share of full scale, `acceleration` the specific force in the cell frame.
#define ROBOTSKIN_COLUMN(name, is_signed, first, channels, column, blank, unit) CellArray<Column<channels>> column;
  RS_SENSORS(ROBOTSKIN_COLUMN)
#undef ROBOTSKIN_COLUMN
  CellArray<float> distance;          // (N) metres, estimated from proximity; +inf where nothing is near
  CellArray<std::int64_t> stamp_ns;   // (N) host clock at the sample
  CellArray<Health> health;           // (N)
  CellArray<std::uint8_t> saturated;  // (N) 1 where a channel is at the end of its range
  std::int64_t time_ns = 0;           // host clock when the driver handed out these samples
  SensorSet sensors = all_sensors;    // that the skin has

  bool has(Sensor sensor) const noexcept { return (sensors & only(sensor)) != 0; }

  void resize(std::size_t cells, SensorSet present = all_sensors) {
    constexpr float unknown = std::numeric_limits<float>::quiet_NaN();
    sensors = present;
#define ROBOTSKIN_BLANK(name, is_signed, first, channels, column, blank, unit) \
  column.assign(cells, filled<channels>(has(Sensor::name) ? static_cast<float>(blank) : unknown));
    RS_SENSORS(ROBOTSKIN_BLANK)
#undef ROBOTSKIN_BLANK
    distance.assign(cells, has(Sensor::proximity) ? std::numeric_limits<float>::infinity() : unknown);
    stamp_ns.assign(cells, 0);
    health.assign(cells, Health::never_seen);
    saturated.assign(cells, 0);
  }

  std::size_t size() const { return proximity.size(); }
};

}  // namespace robotskin::skin
