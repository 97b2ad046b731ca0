// SPDX-License-Identifier: Apache-2.0
// What a skin reader knows, as bytes, so that a recording can be entered in the middle of a run.
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>

#include "skin/skin_reader.hpp"

namespace robotskin::skin {
namespace {

constexpr std::int64_t version = 1;
constexpr std::int64_t time_limit_ns = std::int64_t{1} << 61;

template <class Item>
std::span<const std::uint8_t> bytes_of(const Item* items, std::size_t count) {
  static_assert(std::is_trivially_copyable_v<Item>);
  return {reinterpret_cast<const std::uint8_t*>(items), count * sizeof(Item)};
}

}  // namespace

std::array<std::span<const std::uint8_t>, SkinReader::keyframe_parts_count> SkinReader::keyframe_parts() const {
  keyframe_header_ = {version, static_cast<std::int64_t>(cells_), tare_ns_, tare_end_ns_};
  return {bytes_of(keyframe_header_.data(), keyframe_header_.size()), bytes_of(taken_.data(), cells_),
          bytes_of(cadence_.data(), cells_), bytes_of(force_offset_.data(), cells_), bytes_of(sum_.data(), cells_)};
}

void SkinReader::restore(std::span<const std::uint8_t> keyframe) {
  const auto refuse = [](const std::string& why) { throw std::invalid_argument("keyframe of a skin reader: " + why); };
  std::array<std::int64_t, 4> header{};
  const std::size_t a_cell = sizeof(std::uint32_t) + sizeof(Cadence) + sizeof(std::array<float, 3>) + sizeof(Sum);
  if (keyframe.size() < sizeof header) refuse("it is cut short");
  std::memcpy(header.data(), keyframe.data(), sizeof header);
  if (header[0] != version) refuse("version " + std::to_string(header[0]) + ", known is " + std::to_string(version));
  if (header[1] != static_cast<std::int64_t>(cells_)) {
    refuse("of " + std::to_string(header[1]) + " cells, the skin has " + std::to_string(cells_));
  }
  if (keyframe.size() != sizeof header + cells_ * a_cell) refuse("its length does not fit its cells");
  const auto possible = [](std::int64_t time_ns) { return time_ns > -time_limit_ns && time_ns < time_limit_ns; };
  if (header[2] < 0 || !possible(header[2]) || !possible(header[3])) refuse("impossible times");
  std::vector<Cadence> cadence(cells_);
  std::memcpy(cadence.data(), keyframe.data() + sizeof header + cells_ * sizeof(std::uint32_t),
              cells_ * sizeof(Cadence));
  for (const Cadence& one : cadence) {
    if (!possible(one.stamp_ns) || one.period_ns < 0 || one.period_ns > options_.event_fresh_ns) {
      refuse("impossible times");
    }
  }
  const std::uint8_t* from = keyframe.data() + sizeof header;
  const auto take = [&](auto& items) {
    std::memcpy(items.data(), from, cells_ * sizeof(items[0]));
    from += cells_ * sizeof(items[0]);
  };
  take(taken_);
  take(cadence_);
  take(force_offset_);
  take(sum_);
  tare_ns_ = header[2];
  tare_end_ns_ = header[3];
  restored_ = true;
}

}  // namespace robotskin::skin
