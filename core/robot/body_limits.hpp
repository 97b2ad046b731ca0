// SPDX-License-Identifier: Apache-2.0
// Forces and pressures with which parts of the robot may press on regions of a person's body, in the manner of
// ISO/TS 15066. No number is ours: a file with one names its source (`robotskin.robots.body_limits`).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "model/joint_state.hpp"
#include "skin/skin_state.hpp"

namespace robotskin::robot {

// Of force (N) or pressure (N/cm^2); infinite: none is given.
struct ContactLimit {
  double transient = std::numeric_limits<double>::infinity();
  double quasi_static = std::numeric_limits<double>::infinity();

  // A kind of contact without a limit of its own has that of the other kind.
  constexpr double of(bool is_transient) const noexcept {
    constexpr double none = std::numeric_limits<double>::infinity();
    const double own = is_transient ? transient : quasi_static;
    return own < none ? own : (is_transient ? quasi_static : transient);
  }
};

// A region and the cells that may meet it.
struct BodyRegion {
  std::string name;
  std::vector<std::size_t> cells;
  ContactLimit force;
  ContactLimit pressure;
  double transient_s = 0;  // from its beginning on a contact is transient for so long, then quasi-static
};

struct BodyLimits {
  std::vector<BodyRegion> regions;
  double silent_n = 0;                // a cell that feels no more is not touched
  double smallest_alive_share = 0.5;  // of a region's cells, below it the force on the region is not known
};

enum class BodyQuantity : std::uint8_t { none, force, pressure, saturated, silent };

// What was beyond a limit, in a form that is copied in the cycle.
struct BodyExcess {
  static constexpr std::size_t name_bytes = 48;
  std::array<char, name_bytes> region{};  // ends with 0
  BodyQuantity quantity = BodyQuantity::none;
  bool transient = false;
  double value = 0;  // N, N/cm^2, newton of the saturated sensor, or the share of cells alive
  double limit = 0;
};

// Over which a cell's force is a pressure: that of its hexagon.
double cell_area_cm2() noexcept;

// In words: region, value and limit.
std::string text_of(const BodyExcess& excess);

class BodyMonitor {
 public:
  // Throws GuardError for a region without name or cells, and for numbers that are none.
  explicit BodyMonitor(BodyLimits limits);

  // Whether every region is within its limits; else `excess` tells the first that is not. A force that cannot be known
  // is within none: a sensor at the end of its range, too few cells alive. Never allocates or throws.
  [[nodiscard]] bool within(const skin::SkinState& skin, std::int64_t now_ns, BodyExcess& excess) noexcept;

 private:
  struct Felt {
    double force_n = 0, largest_cell_n = 0, saturated_n = 0;
    std::size_t alive = 0;
  };
  Felt feel(const BodyRegion& region, const skin::SkinState& skin) const noexcept;

  BodyLimits limits_;
  std::vector<std::int64_t> touched_since_ns_;  // (regions) never_ns: not touched
};

}  // namespace robotskin::robot
