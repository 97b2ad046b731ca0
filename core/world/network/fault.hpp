// SPDX-License-Identifier: Apache-2.0
// What can go wrong in a network, when and where: a fault as a value, and as text that can be read again.
//
// One fault is `kind:key=value,key=value@time`, several are joined by `;`: `cut:cell=12,port=3@120ms;
// reboot:cell=7,off=2ms@150ms`. `random:4@100ms` stands for four faults drawn from the run's seed, from that time on.
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "world/network/wiring.hpp"

namespace robotskin::world {

// A kind, by its number: fault_type.hpp says what it is, a file of faults/ each.
enum class FaultKind : std::uint8_t {};

enum class FaultWay : std::uint8_t { out, in };
// `all` is the first three; those behind it are not drawn.
enum class FaultPart : std::uint8_t { route, queues, sampling, all, arq, torque, commands, settings, whole };
enum class FaultFrame : std::uint8_t { tick, grant, command, joints };  // that carry a tag

// Of the targets and parameters, a kind uses those its keys name; the others keep these values.
struct Fault {
  FaultKind kind{};
  std::int64_t time_ns = 0;
  std::int32_t cell = -1, unit = -1;  // indices
  std::int32_t port = 0;              // 1 to 4 of a cell, 1 to 15 of a section unit; 0: all
  std::int32_t to = -1;               // cell or unit
  std::int32_t to_port = 0;
  std::int64_t lasts_ns = 0;  // `for`, `off`, `ago`; 0: for good
  std::int64_t by_ns = 0;     // `by`, `period`
  std::int32_t count = 0;     // `times`, `size`, `bytes`, `frames`
  double amount = 0;          // `rate`, `share`, `ppm`
  FaultWay way = FaultWay::out;
  FaultPart part = FaultPart::route;
  FaultFrame what = FaultFrame::tick;

  bool operator==(const Fault&) const = default;
};

// The message names the fault as it was given, the value, and the valid choices.
class FaultError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

std::string_view name_of(FaultKind kind);
std::vector<std::string_view> fault_names();
std::string fault_help();  // a line a kind

// Reads one fault, and all of a specification in order of time; `random:N` draws by `seed`. Throws FaultError, also for
// targets that `wiring` does not have.
Fault parse_fault(std::string_view text);
std::vector<Fault> parse_faults(std::string_view text, const Wiring& wiring, std::uint64_t seed);

// As text that parse_fault reads as the same fault.
std::string to_string(const Fault& fault);
std::string to_string(std::span<const Fault> faults);

// Throws FaultError if the wiring has no such target.
void check_fault(const Fault& fault, const Wiring& wiring);

// `count` faults of any kind, with targets of `wiring`, from `from_ns` on: half of them within 10 ms of the one before,
// the others within 100 ms.
std::vector<Fault> draw_faults(const Wiring& wiring, std::int32_t count, std::int64_t from_ns, std::uint64_t seed);

}  // namespace robotskin::world
