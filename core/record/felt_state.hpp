// SPDX-License-Identifier: Apache-2.0
// A whole skin state as an entry of a tape: for skins whose samples do not come through our driver.
//
// in   the state of a tick, after what cannot be was taken out (distrust)
// out  little-endian: sensors u32, cells u32, fresh_ns i64, time_ns i64; f32 columns of the sensors that the skin has,
// in
//      the order of channels.h; distance f32 where it has proximity; stamp_ns i64; health u8; saturated u8
// bad  bytes that no recorder writes: std::invalid_argument
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "skin/skin_state.hpp"

namespace robotskin::record {

struct FeltHeader {
  std::uint32_t sensors, cells;
  std::int64_t fresh_ns, time_ns;
};
static_assert(sizeof(FeltHeader) == 24);

// The parts of an entry, shown where they lie.
struct FeltParts {
  FeltParts(const skin::SkinState& state, std::int64_t fresh_ns) noexcept;
  FeltParts(const FeltParts&) = delete;

  std::span<const std::span<const std::uint8_t>> spans() const noexcept { return {part_.data(), parts_}; }

 private:
  FeltHeader header_;
  std::array<std::span<const std::uint8_t>, 5 + static_cast<std::size_t>(skin::Sensor::count)> part_;
  std::size_t parts_ = 0;
};

// Fills the state, which has the skin's cells; how old a sample of a living cell may be, ns.
std::int64_t take_felt(std::span<const std::uint8_t> payload, skin::SkinState& state);

}  // namespace robotskin::record
