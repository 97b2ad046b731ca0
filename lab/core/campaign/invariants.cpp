// SPDX-License-Identifier: Apache-2.0
#include "campaign/invariants.hpp"

#include <cstdio>

namespace robotskin::campaign {
namespace {

struct Entry {
  std::string_view name;
  int number;
  std::string_view text;
};
#define ROBOTSKIN_INVARIANT_ENTRY(name, number, text) {#name, number, text},
constexpr std::array<Entry, invariant_count> entries{{ROBOTSKIN_INVARIANTS(ROBOTSKIN_INVARIANT_ENTRY)}};
#undef ROBOTSKIN_INVARIANT_ENTRY

const Entry& entry_of(Invariant invariant) {
  return entries[static_cast<std::size_t>(invariant)];
}

}  // namespace

std::string_view name_of(Invariant invariant) {
  return entry_of(invariant).name;
}

int number_of(Invariant invariant) {
  return entry_of(invariant).number;
}

std::string_view text_of(Invariant invariant) {
  return entry_of(invariant).text;
}

std::string Break::text() const {
  char time[32];
  std::snprintf(time, sizeof time, "%.3f ms", 1e-6 * static_cast<double>(time_ns));
  std::string out =
      "I" + std::to_string(number_of(invariant)) + " " + std::string(name_of(invariant)) + " at " + time + ":";
  if (!cells.empty()) out += cells.size() == 1 ? " cell" : " cells";
  for (const std::size_t cell : cells) out += " " + std::to_string(cell);
  for (const Value& value : values) out += ", " + std::string(value.name) + " " + std::to_string(value.value);
  return out;
}

void BreakLog::add(Invariant invariant, std::int64_t time_ns, std::initializer_list<std::size_t> cells,
                   std::initializer_list<Value> values) {
  ++count_;
  if (++counts_[static_cast<std::size_t>(invariant)] > kept_each) return;
  kept_.push_back({invariant, time_ns, cells, values});
}

}  // namespace robotskin::campaign
