// SPDX-License-Identifier: Apache-2.0
// From a cell's key to its row in the driver's tables: one look-up table for each section-unit group.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "driver/sample.hpp"

namespace robotskin::driver {

class CellIndex {
 public:
  static constexpr std::size_t groups_max = 64;

  // The row of keys[i] is i. `spare_cells` more may be added while running, of at most `spare_groups` new groups.
  // Throws std::invalid_argument for a key that is given twice or has no valid id.
  CellIndex(std::span<const CellKey> keys, std::size_t spare_cells, std::size_t spare_groups)
      : capacity_(keys.size() + spare_cells) {
    keys_.reserve(capacity_);
    groups_.reserve(groups_max);
    for (const CellKey key : keys) {
      Group* group = find(static_cast<std::uint16_t>(key >> 16));
      if (group == nullptr) {
        if (groups_.size() == groups_max) {
          throw std::invalid_argument("cells of more than " + std::to_string(groups_max) + " section-unit groups");
        }
        groups_.push_back({static_cast<std::uint16_t>(key >> 16), std::vector<std::int32_t>(ids, no_row)});
        group = &groups_.back();
      }
      const std::uint16_t id = static_cast<std::uint16_t>(key);
      if (!valid(id)) {
        throw std::invalid_argument("cell id " + std::to_string(id) + " of section unit " + std::to_string(key >> 16) +
                                    " is not between 1 and 16382");
      }
      if (group->row[id] != no_row) {
        throw std::invalid_argument("cell id " + std::to_string(id) + " of section unit " + std::to_string(key >> 16) +
                                    " is given twice");
      }
      group->row[id] = static_cast<std::int32_t>(keys_.size());
      keys_.push_back(key);
    }
    for (std::size_t i = 0; i < spare_groups && groups_.size() < groups_max; ++i)
      spare_tables_.emplace_back(ids, no_row);
  }

  static constexpr std::int32_t no_row = -1;

  struct Group {
    std::uint16_t number;
    std::vector<std::int32_t> row;  // by id
  };

  // The group, null if it is unknown.
  Group* find(std::uint16_t number) {
    for (Group& group : groups_) {
      if (group.number == number) return &group;
    }
    return nullptr;
  }

  // The group, added if there is spare room for it; null if it is unknown.
  Group* group(std::uint16_t group) {
    Group* known = find(group);
    if (known != nullptr || spare_tables_.empty()) return known;
    groups_.push_back({group, std::move(spare_tables_.back())});
    spare_tables_.pop_back();
    return &groups_.back();
  }

  static bool valid(std::uint32_t id) { return id >= RS_ID_FIRST && id <= RS_ID_LAST; }

  // The row of a cell with a valid id, added if there is spare room for it.
  std::int32_t row(Group& group, std::uint32_t id) {
    std::int32_t& row = group.row[id];
    if (row == no_row && keys_.size() < capacity_) {
      row = static_cast<std::int32_t>(keys_.size());
      keys_.push_back(CellKey{group.number} << 16 | id);
    }
    return row;
  }

  std::size_t capacity() const { return capacity_; }
  const std::vector<CellKey>& keys() const { return keys_; }
  const std::vector<Group>& groups() const { return groups_; }

 private:
  static constexpr std::size_t ids = RS_ID_LAST + 1;

  std::size_t capacity_;
  std::vector<CellKey> keys_;
  std::vector<Group> groups_;
  std::vector<std::vector<std::int32_t>> spare_tables_;
};

}  // namespace robotskin::driver
