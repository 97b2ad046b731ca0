// SPDX-License-Identifier: Apache-2.0
#include "record/felt_state.hpp"

#include <cstring>
#include <stdexcept>
#include <string>

namespace robotskin::record {
namespace {

// Calls `part` with each array of a state that an entry holds, in its order.
template <class State, class Call>
void each_part(State& state, const Call& part) {
#define ROBOTSKIN_PART(name, is_signed, first, channels, column, blank, unit) \
  if (state.has(skin::Sensor::name)) part(state.column);
  RS_SENSORS(ROBOTSKIN_PART)
#undef ROBOTSKIN_PART
  if (state.has(skin::Sensor::proximity)) part(state.distance);
  part(state.stamp_ns);
  part(state.health);
  part(state.saturated);
}

}  // namespace

FeltParts::FeltParts(const skin::SkinState& state, std::int64_t fresh_ns) noexcept
    : header_{state.sensors, static_cast<std::uint32_t>(state.size()), fresh_ns, state.time_ns} {
  part_[parts_++] = {reinterpret_cast<const std::uint8_t*>(&header_), sizeof header_};
  each_part(state, [this](const auto& array) {
    part_[parts_++] = {reinterpret_cast<const std::uint8_t*>(array.data()), array.size() * sizeof array[0]};
  });
}

std::int64_t take_felt(std::span<const std::uint8_t> payload, skin::SkinState& state) {
  FeltHeader header;
  if (payload.size() < sizeof header) throw std::invalid_argument("recording: a skin state is cut short");
  std::memcpy(&header, payload.data(), sizeof header);
  if (header.cells != state.size() || header.sensors == 0 || (header.sensors & ~skin::all_sensors) != 0 ||
      header.fresh_ns <= 0)
    throw std::invalid_argument("recording: a skin state of " + std::to_string(header.cells) + " cells, sensors " +
                                std::to_string(header.sensors) + ": the layout has " + std::to_string(state.size()) +
                                " cells");
  if (header.sensors != state.sensors) state.resize(header.cells, header.sensors);
  std::size_t bytes = sizeof header;
  each_part(state, [&](const auto& array) { bytes += array.size() * sizeof array[0]; });
  if (payload.size() != bytes)
    throw std::invalid_argument("recording: a skin state of " + std::to_string(payload.size()) + " bytes, not " +
                                std::to_string(bytes));
  const std::size_t healths = bytes - 2 * state.size();
  for (std::size_t cell = 0; cell < state.size(); ++cell)
    if (payload[healths + cell] > static_cast<std::uint8_t>(skin::Health::never_seen))
      throw std::invalid_argument("recording: health " + std::to_string(payload[healths + cell]) + " is none");
  std::size_t at = sizeof header;
  each_part(state, [&](auto& array) {
    std::memcpy(array.data(), payload.data() + at, array.size() * sizeof array[0]);
    at += array.size() * sizeof array[0];
  });
  state.time_ns = header.time_ns;
  return header.fresh_ns;
}

}  // namespace robotskin::record
