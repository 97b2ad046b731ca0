// SPDX-License-Identifier: Apache-2.0
// All that samples depend on, as bytes, so that a recording can begin, and be entered, in the middle of a run.
#include <algorithm>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "driver/driver.hpp"

namespace robotskin::driver {
namespace {

constexpr std::uint32_t keyframe_version = 1;
constexpr std::int64_t time_limit_ns = std::int64_t{1} << 61;  // no clock of a host or unit comes here

template <class Item>
std::span<const std::uint8_t> bytes_of(std::span<const Item> items) {
  static_assert(std::is_trivially_copyable_v<Item>);
  return {reinterpret_cast<const std::uint8_t*>(items.data()), items.size_bytes()};
}

bool possible(std::int64_t time_ns) {
  return time_ns > -time_limit_ns && time_ns < time_limit_ns;
}

[[noreturn]] void refuse(const std::string& why) {
  throw std::invalid_argument("keyframe of a recording: " + why);
}

// Cuts typed arrays off the front of bytes.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : left_(bytes) {}

  template <class Item>
  std::vector<Item> take(std::size_t count) {
    if (left_.size() / sizeof(Item) < count) refuse("it is cut short");
    std::vector<Item> items(count);
    std::memcpy(items.data(), left_.data(), count * sizeof(Item));
    left_ = left_.subspan(count * sizeof(Item));
    return items;
  }

  bool empty() const { return left_.empty(); }

 private:
  std::span<const std::uint8_t> left_;
};

// Version and sizes: a keyframe is memory as it was, for drivers with the same rows alone.
constexpr std::uint64_t format_of(std::size_t link_bytes) {
  return std::uint64_t{keyframe_version} << 48 | sizeof(Sample) << 36 | sizeof(TopologyRow) << 24 |
         sizeof(UnitRow) << 12 | link_bytes;
}

}  // namespace

Driver::KeyframeParts Driver::keyframe_parts() const {
  keyframe_header_ = {
      format_of(sizeof(Link)), index_.capacity(), index_.keys().size(), unit_count_, samples_.publications(), 0};
  return {bytes_of(std::span<const std::uint64_t>(keyframe_header_)),
          bytes_of(std::span<const CellKey>(index_.keys())),
          bytes_of(samples_.rows()),
          bytes_of(topology_.rows()),
          bytes_of(units_.rows().first(unit_count_)),
          bytes_of(std::span<const Link>(links_).first(unit_count_)),
          bytes_of(std::span<const std::uint32_t>(unit_names_).first(unit_count_)),
          bytes_of(std::span<const std::uint32_t>(heard_)),
          bytes_of(std::span<const std::uint16_t>(arrival_port_)),
          bytes_of(std::span<const std::uint8_t>(references_))};
}

void Driver::restore(std::span<const std::uint8_t> keyframe) {
  Reader reader(keyframe);
  const auto header = reader.take<std::uint64_t>(keyframe_header_.size());
  const std::uint64_t rows = header[1], units = header[3], publications = header[4];
  if (header[0] != format_of(sizeof(Link))) refuse("of a version with rows of other sizes than this driver's");
  if (rows != index_.capacity()) {
    refuse("of " + std::to_string(rows) + " cells: this driver has room for " + std::to_string(index_.capacity()));
  }
  if (header[2] > rows || units > units_max || publications == 0) refuse("its counts cannot be");
  const auto keys = reader.take<CellKey>(header[2]);
  const auto samples = reader.take<Sample>(rows);
  const auto topology = reader.take<TopologyRow>(rows);
  const auto unit_rows = reader.take<UnitRow>(units);
  const auto links = reader.take<Link>(units);
  const auto names = reader.take<std::uint32_t>(units);
  const auto heard = reader.take<std::uint32_t>(rows);
  const auto way = reader.take<std::uint16_t>(rows);
  const auto references = reader.take<std::uint8_t>(rows);
  if (!reader.empty()) refuse("bytes follow its end");
  if (!std::equal(index_.keys().begin(), index_.keys().end(), keys.begin(),
                  keys.begin() + static_cast<std::ptrdiff_t>(std::min(keys.size(), index_.keys().size())))) {
    refuse("of other cells than this driver's");
  }
  for (const Sample& sample : samples) {
    if (!possible(sample.stamp_ns) || !possible(sample.arrival_ns) || !possible(sample.moved_ns) ||
        !possible(sample.gone_ns)) {
      refuse("a sample has an impossible time");
    }
  }
  for (const UnitRow& unit : unit_rows) {
    if (!possible(unit.heard_ns)) refuse("a section unit has an impossible time");
  }
  for (const Link& link : links) {
    if (!link.clock.possible(time_limit_ns)) refuse("a section unit has an impossible clock");
  }
  for (const CellKey key : keys) {
    if (!CellIndex::valid(key & 0xFFFFU)) refuse("a cell has no valid id");
  }
  for (const CellKey key : std::span(keys).subspan(index_.keys().size())) {
    CellIndex::Group* group = index_.group(static_cast<std::uint16_t>(key >> 16));
    if (group == nullptr) refuse("of more section-unit groups than this driver has room for");
    index_.row(*group, key & 0xFFFFU);
  }
  samples_.restore(samples, publications - 1);
  topology_.restore(topology, publications - 1);
  units_.restore(unit_rows, publications - 1);
  std::copy(links.begin(), links.end(), links_.begin());
  std::copy(names.begin(), names.end(), unit_names_.begin());
  unit_count_ = units;
  heard_ = heard;
  arrival_port_ = way;
  references_ = references;
}

}  // namespace robotskin::driver
