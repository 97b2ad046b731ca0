// SPDX-License-Identifier: Apache-2.0
// Where random faults get their places and times from.
#pragma once

#include <cstdint>
#include <span>

#include "world/network/fault.hpp"
#include "world/random.hpp"

namespace robotskin::world {

class FaultDraw {
 public:
  static constexpr std::int64_t ms = 1000000;

  FaultDraw(const Wiring& wiring, std::uint64_t seed);

  const Wiring& wiring() const { return wiring_; }
  std::uint64_t below(std::uint64_t limit) { return stream_.below(limit); }
  std::int64_t time_between(std::int64_t low_ns, std::int64_t high_ns);  // whole 10 us
  // Whether the present fault ends at all is drawn before the rest of it.
  void begin_fault() { for_a_while_ = below(2) == 0; }
  std::int64_t while_ns(std::int64_t low_ns, std::int64_t high_ns) {
    return for_a_while_ ? time_between(low_ns, high_ns) : 0;
  }

  std::int32_t cells() const { return static_cast<std::int32_t>(wiring_.cell_count()); }
  std::int32_t units() const { return static_cast<std::int32_t>(wiring_.units.size()); }
  std::int32_t cell() { return static_cast<std::int32_t>(below(static_cast<std::uint64_t>(cells()))); }
  std::int32_t unit() { return static_cast<std::int32_t>(below(static_cast<std::uint64_t>(units()))); }
  std::int32_t port(std::int32_t cell);        // with something at it
  std::int32_t wired_port(std::int32_t cell);  // that, or the cable of a section unit
  std::int32_t unit_port(std::int32_t unit);
  // A wire; one in eight is a cable.
  void place(Fault& fault);

 private:
  const Wiring& wiring_;
  RandomStream stream_;
  bool for_a_while_ = false;
};

// Wirings that a kind needs before it can be drawn.
bool has_units(const Wiring& wiring, std::span<const Fault> so_far);
bool has_two_units(const Wiring& wiring, std::span<const Fault> so_far);
bool has_two_cells(const Wiring& wiring, std::span<const Fault> so_far);

}  // namespace robotskin::world
