// SPDX-License-Identifier: Apache-2.0
// Faults as text: one table says which keys a kind takes, for reading, checking and printing.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <variant>

#include "world/network/fault_type.hpp"

namespace robotskin::world {
namespace {

constexpr std::array<std::string_view, 2> ways{"out", "in"};
constexpr std::array<std::string_view, 9> parts{"route",  "queues",   "sampling", "all",  "arq",
                                                "torque", "commands", "settings", "whole"};
constexpr std::array<std::string_view, 4> frames{"tick", "grant", "command", "joints"};

// Words of faults that were written before these had the names of today; they are still read.
struct OldWord {
  std::string_view was, is;
};
constexpr std::array<OldWord, 2> old_words{{{"twin", "duplicate_id"}, {"retention", "arq"}}};

std::string_view todays(std::string_view word) {
  const auto* old = std::ranges::find(old_words, word, &OldWord::was);
  return old == old_words.end() ? word : old->is;
}

using Member = std::variant<std::int32_t Fault::*, std::int64_t Fault::*, double Fault::*, FaultWay Fault::*,
                            FaultPart Fault::*, FaultFrame Fault::*>;  // the second is a time

struct Key {
  std::string_view name;
  Member member;
  double low = 0, high = 0;  // of numbers; times in nanoseconds
};

constexpr double hour_ns = 3.6e12;
constexpr std::array<Key, 20> key_table{{{"cell", &Fault::cell, 0, 1e9},
                                         {"unit", &Fault::unit, 0, 1e9},
                                         {"port", &Fault::port, 1, 15},
                                         {"to", &Fault::to, -1, 1e9},
                                         {"to_port", &Fault::to_port, 1, 4},
                                         {"for", &Fault::lasts_ns, 0, hour_ns},
                                         {"off", &Fault::lasts_ns, 0, hour_ns},
                                         {"ago", &Fault::lasts_ns, 0, hour_ns},
                                         {"by", &Fault::by_ns, -hour_ns, hour_ns},
                                         {"period", &Fault::by_ns, 1e3, hour_ns},
                                         {"times", &Fault::count, 1, 1000},
                                         {"size", &Fault::count, 1, 1e6},
                                         {"bytes", &Fault::count, 1, 8192},
                                         {"frames", &Fault::count, 1, 10000},
                                         {"rate", &Fault::amount, 0, 0.5},
                                         {"share", &Fault::amount, 0, 1},
                                         {"ppm", &Fault::amount, -100000, 100000},
                                         {"way", &Fault::way},
                                         {"part", &Fault::part},
                                         {"what", &Fault::what}}};

// A key as a kind takes it.
struct Use {
  const Key* key;
  bool required;
  std::string_view otherwise;  // its value as text if it is left out; empty: as in Fault
  std::int32_t first = 0;      // what the first of them is called: section units count from 1, as on every page
};

template <typename Names>
std::string list_of(const Names& all) {
  std::string text;
  for (const auto& name : all) text += (text.empty() ? "" : ", ") + std::string(name);
  return text;
}

std::vector<std::string_view> split(std::string_view text, char at) {
  std::vector<std::string_view> pieces;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = std::min(text.find(at, start), text.size());
    pieces.push_back(text.substr(start, end - start));
    start = end + 1;
  }
  return pieces;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\n");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\n") - first + 1);
}

const FaultType& type_of(FaultKind kind) {
  return *fault_types()[static_cast<std::size_t>(kind)];
}

std::vector<Use> uses_of(FaultKind kind) {
  std::vector<Use> uses;
  for (std::string_view word : split(type_of(kind).keys, ' ')) {
    if (word.empty()) continue;
    Use use{nullptr, false, {}};
    if (const std::size_t equals = word.find('='); equals != std::string_view::npos) {
      use.otherwise = word.substr(equals + 1);
      word = word.substr(0, equals);
    } else if (word.back() == '!') {
      use.required = true;
      word.remove_suffix(1);
    }
    use.key = std::ranges::find(key_table, word, &Key::name);
    use.first = word == "unit" || (word == "to" && type_of(kind).to == FaultTo::unit) ? 1 : 0;
    uses.push_back(use);
  }
  return uses;
}

template <typename Number>
std::optional<Number> number_of(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

struct TimeUnit {
  std::string_view name;
  std::int64_t ns;
};
constexpr std::array<TimeUnit, 4> time_units{{{"s", 1000000000}, {"ms", 1000000}, {"us", 1000}, {"ns", 1}}};

std::optional<std::int64_t> time_of(std::string_view text) {
  const std::size_t suffix = text.find_last_of("0123456789.") + 1;
  const std::optional<double> value = number_of<double>(text.substr(0, suffix));
  if (!value) return std::nullopt;
  const auto* unit = std::ranges::find(time_units, text.substr(suffix), &TimeUnit::name);
  if (unit == time_units.end())
    return *value == 0 && suffix == text.size() ? std::optional<std::int64_t>(0) : std::nullopt;
  const double ns = *value * static_cast<double>(unit->ns);
  if (!(std::abs(ns) <= hour_ns)) return std::nullopt;
  return std::llround(ns);
}

std::string time_text(std::int64_t ns) {
  if (ns == 0) return "0";
  const auto* unit = std::ranges::find_if(time_units, [ns](const TimeUnit& u) { return ns % u.ns == 0; });
  return std::to_string(ns / unit->ns) + std::string(unit->name);
}

std::string number_text(double value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

// Throws with `whole`, the fault as given.
void set(Fault& fault, const Use& use, std::string_view text, std::string_view whole) {
  const Key& key = *use.key;
  const auto refuse = [&](const std::string& valid) {
    throw FaultError("fault '" + std::string(whole) + "': " + std::string(key.name) + "=" + std::string(text) + ": " +
                     valid);
  };
  const auto within = [&](double value) { return value >= key.low && value <= key.high; };
  const auto range = [&](const std::string& of) {
    return of + " from " + number_text(key.low + use.first) + " to " + number_text(key.high + use.first);
  };
  if (const auto* integer = std::get_if<std::int32_t Fault::*>(&key.member)) {
    const auto value = number_of<std::int32_t>(text);
    if (!value || !within(static_cast<double>(*value) - use.first)) refuse(range("a whole number"));
    fault.** integer = *value - use.first;
  } else if (const auto* time = std::get_if<std::int64_t Fault::*>(&key.member)) {
    const auto value = time_of(text);
    if (!value || !within(static_cast<double>(*value)))
      refuse("a time such as 500us, 2ms or 1.5s, from " + time_text(std::llround(key.low)) + " to " +
             time_text(std::llround(key.high)));
    fault.** time = *value;
  } else if (const auto* real = std::get_if<double Fault::*>(&key.member)) {
    const auto value = number_of<double>(text);
    if (!value || !within(*value)) refuse(range("a number"));
    fault.** real = *value;
  } else if (std::holds_alternative<FaultWay Fault::*>(key.member)) {
    const auto* at = std::ranges::find(ways, text);
    if (at == ways.end()) refuse("choose from " + list_of(ways));
    fault.way = static_cast<FaultWay>(at - ways.begin());
  } else if (std::holds_alternative<FaultPart Fault::*>(key.member)) {
    const auto* at = std::ranges::find(parts, todays(text));
    if (at == parts.end()) refuse("choose from " + list_of(parts));
    fault.part = static_cast<FaultPart>(at - parts.begin());
  } else {
    const auto* at = std::ranges::find(frames, text);
    if (at == frames.end()) refuse("choose from " + list_of(frames));
    fault.what = static_cast<FaultFrame>(at - frames.begin());
  }
}

std::string value_text(const Fault& fault, const Use& use) {
  const Key& key = *use.key;
  if (const auto* integer = std::get_if<std::int32_t Fault::*>(&key.member))
    return std::to_string(fault.**integer + use.first);
  if (const auto* time = std::get_if<std::int64_t Fault::*>(&key.member)) return time_text(fault.**time);
  if (const auto* real = std::get_if<double Fault::*>(&key.member)) return number_text(fault.**real);
  if (std::holds_alternative<FaultWay Fault::*>(key.member))
    return std::string(ways[static_cast<std::size_t>(fault.way)]);
  if (std::holds_alternative<FaultPart Fault::*>(key.member))
    return std::string(parts[static_cast<std::size_t>(fault.part)]);
  return std::string(frames[static_cast<std::size_t>(fault.what)]);
}

std::string keys_text(const std::vector<Use>& uses) {
  std::string text;
  for (const Use& use : uses) {
    text += (text.empty() ? "" : ", ") + std::string(use.key->name);
    if (!use.otherwise.empty()) text += "=" + std::string(use.otherwise);
  }
  return text.empty() ? "none" : text;
}

// The fault with every key left out.
Fault blank(FaultKind kind, const std::vector<Use>& uses) {
  Fault fault;
  fault.kind = kind;
  for (const Use& use : uses)
    if (!use.otherwise.empty()) set(fault, use, use.otherwise, name_of(kind));
  return fault;
}

struct Pieces {
  std::string_view kind, keys, time;
};

Pieces pieces_of(std::string_view text) {
  Pieces pieces;
  if (const std::size_t at = text.find('@'); at != std::string_view::npos) {
    pieces.time = trimmed(text.substr(at + 1));
    text = text.substr(0, at);
  }
  const std::size_t colon = std::min(text.find(':'), text.size());
  pieces.kind = trimmed(text.substr(0, colon));
  if (colon < text.size()) pieces.keys = trimmed(text.substr(colon + 1));
  return pieces;
}

std::int64_t moment_of(std::string_view time, std::string_view whole) {
  const auto value = time_of(time);
  if (!value || *value < 0)
    throw FaultError("fault '" + std::string(whole) + "': when? it ends in a time such as @120ms, not '@" +
                     std::string(time) + "'");
  return *value;
}

}  // namespace

std::string_view name_of(FaultKind kind) {
  return type_of(kind).name;
}

std::vector<std::string_view> fault_names() {
  std::vector<std::string_view> names;
  for (const FaultType* type : fault_types()) names.push_back(type->name);
  return names;
}

std::string fault_help() {
  std::string help;
  for (const FaultType* type : fault_types()) {
    const std::string keys = keys_text(uses_of(static_cast<FaultKind>(type->number)));
    help += std::string(type->name) + (keys == "none" ? "" : ":" + keys) + "  " + std::string(type->text) + "\n";
  }
  return help;
}

Fault parse_fault(std::string_view text) {
  text = trimmed(text);
  const Pieces pieces = pieces_of(text);
  const std::vector<std::string_view> names = fault_names();
  const auto name = std::ranges::find(names, todays(pieces.kind));
  if (name == names.end())
    throw FaultError("fault '" + std::string(text) + "': no kind '" + std::string(pieces.kind) + "': choose from " +
                     list_of(names));
  const auto kind = static_cast<FaultKind>(name - names.begin());
  const std::vector<Use> uses = uses_of(kind);
  Fault fault = blank(kind, uses);
  std::vector<const Key*> given;
  if (!pieces.keys.empty()) {
    for (std::string_view pair : split(pieces.keys, ',')) {
      pair = trimmed(pair);
      const std::size_t equals = std::min(pair.find('='), pair.size());
      const std::string_view key = trimmed(pair.substr(0, equals));
      const auto use = std::ranges::find_if(uses, [key](const Use& u) { return u.key->name == key; });
      if (use == uses.end() || equals == pair.size() || std::ranges::count(given, use->key) > 0)
        throw FaultError("fault '" + std::string(text) + "': '" + std::string(pair) + "': " + std::string(*name) +
                         " takes, each once and with a value, " + keys_text(uses));
      set(fault, *use, trimmed(pair.substr(equals + 1)), text);
      given.push_back(use->key);
    }
  }
  for (const Use& use : uses)
    if (use.required && std::ranges::count(given, use.key) == 0)
      throw FaultError("fault '" + std::string(text) + "': " + std::string(*name) + " needs " +
                       std::string(use.key->name) + "; it takes " + keys_text(uses));
  fault.time_ns = moment_of(pieces.time, text);
  return fault;
}

std::vector<Fault> parse_faults(std::string_view text, const Wiring& wiring, std::uint64_t seed) {
  std::vector<Fault> faults;
  for (std::string_view piece : split(text, ';')) {
    piece = trimmed(piece);
    if (piece.empty()) continue;
    const Pieces pieces = pieces_of(piece);
    if (pieces.kind == "random") {
      const auto count = number_of<std::int32_t>(pieces.keys);
      if (!count || *count < 1 || *count > 1000)
        throw FaultError("fault '" + std::string(piece) + "': random:N@TIME draws N faults, 1 to 1000");
      const std::int64_t from_ns = pieces.time.empty() ? 100000000 : moment_of(pieces.time, piece);
      const std::vector<Fault> drawn = draw_faults(wiring, *count, from_ns, seed);
      faults.insert(faults.end(), drawn.begin(), drawn.end());
    } else {
      faults.push_back(parse_fault(piece));
      check_fault(faults.back(), wiring);
    }
  }
  std::ranges::stable_sort(faults, {}, &Fault::time_ns);
  return faults;
}

std::string to_string(const Fault& fault) {
  const std::vector<Use> uses = uses_of(fault.kind);
  const Fault otherwise = blank(fault.kind, uses);
  std::string keys;
  for (const Use& use : uses) {
    const std::string value = value_text(fault, use);
    if (!use.required && value == value_text(otherwise, use)) continue;
    keys += (keys.empty() ? ":" : ",") + std::string(use.key->name) + "=" + value;
  }
  return std::string(name_of(fault.kind)) + keys + "@" + time_text(fault.time_ns);
}

std::string to_string(std::span<const Fault> faults) {
  std::string text;
  for (const Fault& fault : faults) text += (text.empty() ? "" : "; ") + to_string(fault);
  return text;
}

}  // namespace robotskin::world
