// SPDX-License-Identifier: Apache-2.0
// The sensors of a skin by their names in channels.h.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "skin/skin_state.hpp"

namespace robotskin::bindings {

inline std::vector<std::string> sensor_names(skin::SensorSet sensors) {
  std::vector<std::string> names;
#define ROBOTSKIN_NAME(name, is_signed, first, channels, column, blank, unit) \
  if ((sensors & skin::only(skin::Sensor::name)) != 0) names.emplace_back(#name);
  RS_SENSORS(ROBOTSKIN_NAME)
#undef ROBOTSKIN_NAME
  return names;
}

// Throws std::invalid_argument for a name that is none.
inline skin::SensorSet sensor_set(const std::vector<std::string>& names) {
  skin::SensorSet sensors = 0;
  for (const std::string& wanted : names) {
    const skin::SensorSet before = sensors;
#define ROBOTSKIN_NAME(name, is_signed, first, channels, column, blank, unit) \
  if (wanted == #name) sensors |= skin::only(skin::Sensor::name);
    RS_SENSORS(ROBOTSKIN_NAME)
#undef ROBOTSKIN_NAME
    if (sensors != before) continue;
    std::string known;
    for (const std::string& name : sensor_names(skin::all_sensors)) known += (known.empty() ? "" : ", ") + name;
    throw std::invalid_argument("sensor " + wanted + ": each of " + known + " once");
  }
  return sensors;
}

}  // namespace robotskin::bindings
