// SPDX-License-Identifier: Apache-2.0
#include "campaign/case_text.hpp"

#include <array>
#include <charconv>
#include <sstream>
#include <stdexcept>

namespace robotskin::campaign {
namespace {

using world::CellEnd;
using world::LineQuality;

struct Quality {
  std::string_view name;
  double LineQuality::* member;
};
constexpr std::array<Quality, 7> qualities{{{"jitter_us", &LineQuality::jitter_us},
                                            {"lost_share", &LineQuality::lost_share},
                                            {"bit_error_rate", &LineQuality::bit_error_rate},
                                            {"clock_drift_ppm", &LineQuality::clock_drift_ppm},
                                            {"power_up_spread_us", &LineQuality::power_up_spread_us},
                                            {"unit_skew_us", &LineQuality::unit_skew_us},
                                            {"unit_drift_ppm", &LineQuality::unit_drift_ppm}}};

std::string text_of(double value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

std::string text_of(CellEnd end) {
  return end.cell < 0 ? "-" : std::to_string(end.cell) + "." + std::to_string(end.port);
}

std::string hex_of(const std::array<std::uint8_t, RS_CELL_KEY_BYTES>& key) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : key) text += {digits[byte >> 4], digits[byte & 15]};
  return text;
}

// One line, word by word.
class Line {
 public:
  explicit Line(const std::string& text) : text_(text), words_(text) {}

  [[noreturn]] void refuse(const std::string& why) const {
    throw std::invalid_argument("case: '" + text_ + "': " + why);
  }

  bool next(std::string& word) { return static_cast<bool>(words_ >> word); }
  std::string word() {
    std::string word;
    if (!next(word)) refuse("a value is missing");
    return word;
  }
  template <typename Number>
  Number number(const std::string& text) const {
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) refuse("'" + text + "' is no such number");
    return value;
  }
  template <typename Number>
  Number number() {
    return number<Number>(word());
  }
  CellEnd end(const std::string& text) const {
    if (text == "-") return {};
    const std::size_t dot = text.find('.');
    if (dot == std::string::npos) refuse("'" + text + "': a wire's end is cell.port, or -");
    return {number<std::int32_t>(text.substr(0, dot)), number<std::uint8_t>(text.substr(dot + 1))};
  }
  std::string rest() {
    std::string rest;
    std::getline(words_ >> std::ws, rest);
    return rest;
  }

 private:
  std::string text_;
  std::istringstream words_;
};

void read_key(Line& line, FaultCase& read) {
  const std::string text = line.word();
  if (text.size() != 2 * std::size_t{RS_CELL_KEY_BYTES}) line.refuse("a key has 32 hexadecimal digits");
  auto& key = read.options.cell_key.emplace();
  for (std::size_t i = 0; i < key.size(); ++i) {
    const char* digits = text.data() + 2 * i;
    const auto [end, error] = std::from_chars(digits, digits + 2, key[i], 16);
    if (error != std::errc() || end != digits + 2) line.refuse("a key has 32 hexadecimal digits");
  }
  read.keyed = true;
}

void read_cell(Line& line, FaultCase& read) {
  std::array<CellEnd, 4> ends;
  for (CellEnd& end : ends) end = line.end(line.word());
  read.wiring.neighbours.push_back(ends);
  std::string id;  // kept in its flash
  read.wiring.id.push_back(line.next(id) ? line.number<std::uint16_t>(id) : std::uint16_t{RS_ID_NONE});
}

void read_unit(Line& line, FaultCase& read) {
  world::UnitDescription unit;
  unit.group = line.number<std::uint16_t>();
  unit.unit = line.number<std::uint8_t>();
  for (std::string end; line.next(end);) unit.ports.push_back(line.end(end));
  read.wiring.units.push_back(unit);
}

void read_line(Line& line, FaultCase& read, std::string& faults) {
  const std::string name = line.word();
  if (name == "seed") {
    read.seed = read.options.seed = line.number<std::uint64_t>();
  } else if (name == "shape") {
    const std::string shape = line.word();
    std::size_t at = 0;
    while (at < shape_count && name_of(static_cast<Shape>(at)) != shape) ++at;
    if (at == shape_count) line.refuse("no shape '" + shape + "'");
    read.shape = static_cast<Shape>(at);
  } else if (name == "key") {
    read_key(line, read);
  } else if (name == "line") {
    const std::string quality = line.word();
    std::size_t at = 0;
    while (at < qualities.size() && qualities[at].name != quality) ++at;
    if (at == qualities.size()) line.refuse("no quality '" + quality + "'");
    read.options.line.*qualities[at].member = line.number<double>();
  } else if (name == "processor") {
    const std::string processor = line.word();
    std::size_t at = 0;
    while (at < world::processor_names.size() && world::processor_names[at] != processor) ++at;
    if (at == world::processor_names.size()) line.refuse("no processor '" + processor + "'");
    read.options.processor = static_cast<world::Processor>(at);
  } else if (name == "epoch_ns") {
    read.options.epoch_ns = line.number<std::int64_t>();
  } else if (name == "events") {
    read.workload.events = true;
    read.workload.touched_percent = line.number<std::int32_t>();
  } else if (name == "events_hz") {
    read.workload.events_hz = line.number<std::int32_t>();
  } else if (name == "limbs") {
    read.workload.limbs = line.number<std::int32_t>();
  } else if (name == "orders") {
    read.workload.orders = true;
  } else if (name == "touch") {
    read.workload.touch = true;
  } else if (name == "while_forming") {
    read.while_forming = true;
  } else if (name == "duration_ns") {
    read.duration_ns = line.number<std::int64_t>();
  } else if (name == "unit") {
    read_unit(line, read);
  } else if (name == "cell") {
    read_cell(line, read);
  } else if (name == "faults") {
    faults = line.rest();
  } else {
    line.refuse("no such part");
  }
}

// Ends that do not exist would be looked up.
void check_ends(const FaultCase& read) {
  const auto check = [&](CellEnd end) {
    if (end.cell >= static_cast<std::int32_t>(read.wiring.cell_count()) ||
        (end.cell >= 0 && (end.port < 1 || end.port > RS_PORTS)))
      throw std::invalid_argument("case: there is no end " + text_of(end));
  };
  for (const auto& cell : read.wiring.neighbours)
    for (const CellEnd end : cell) check(end);
  for (const world::UnitDescription& unit : read.wiring.units)
    for (const CellEnd end : unit.ports) check(end);
}

}  // namespace

std::string text_of(const FaultCase& drawn) {
  std::string text = "seed " + std::to_string(drawn.seed) + "\nshape " + std::string(name_of(drawn.shape)) + "\n";
  if (drawn.options.cell_key) text += "key " + hex_of(*drawn.options.cell_key) + "\n";
  for (const Quality& quality : qualities)
    text += "line " + std::string(quality.name) + " " + text_of(drawn.options.line.*quality.member) + "\n";
  if (drawn.options.processor != world::Processor::none)
    text +=
        "processor " + std::string(world::processor_names[static_cast<std::size_t>(drawn.options.processor)]) + "\n";
  text += "epoch_ns " + std::to_string(drawn.options.epoch_ns) + "\n";
  if (drawn.workload.events) text += "events " + std::to_string(drawn.workload.touched_percent) + "\n";
  if (drawn.workload.events_hz != Workload{}.events_hz)
    text += "events_hz " + std::to_string(drawn.workload.events_hz) + "\n";
  text += "limbs " + std::to_string(drawn.workload.limbs) + "\n";
  if (drawn.workload.orders) text += "orders\n";
  if (drawn.workload.touch) text += "touch\n";
  if (drawn.while_forming) text += "while_forming\n";
  text += "duration_ns " + std::to_string(drawn.duration_ns) + "\n";
  for (const world::UnitDescription& unit : drawn.wiring.units) {
    text += "unit " + std::to_string(unit.group) + " " + std::to_string(unit.unit);
    for (const CellEnd end : unit.ports) text += " " + text_of(end);
    text += "\n";
  }
  for (std::size_t i = 0; i < drawn.wiring.cell_count(); ++i) {
    text += "cell";
    for (const CellEnd end : drawn.wiring.neighbours[i]) text += " " + text_of(end);
    if (drawn.wiring.id[i] != RS_ID_NONE) text += " " + std::to_string(drawn.wiring.id[i]);
    text += "\n";
  }
  return text + "faults " + world::to_string(drawn.faults) + "\n";
}

FaultCase case_of(std::string_view text) {
  FaultCase read;
  read.options.unasked = true;
  std::string faults;
  std::istringstream lines{std::string(text)};
  for (std::string content; std::getline(lines, content);) {
    if (content.find_first_not_of(" \t\r") == std::string::npos) continue;
    Line line(content);
    read_line(line, read, faults);
  }
  check_ends(read);
  read.whole_lines = read.options.line.lost_share == 0 && read.options.line.bit_error_rate == 0;
  read.options.settings = settings_of(read.workload);
  read.faults = world::parse_faults(faults, read.wiring, read.seed);
  return read;
}

}  // namespace robotskin::campaign
