// SPDX-License-Identifier: Apache-2.0
#include "robot/body_limits.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

#include "robot/guard_error.hpp"
#include "robotskin/geometry.h"
#include "skin/calibration.hpp"

namespace robotskin::robot {
namespace {

// From here a sensor may be at the end of its range: the zeros that host and cell take off have used up the rest.
constexpr double end_of_range_n = 0.9 * skin::channel_scales[RS_CHANNEL_force_1].highest * skin::force_1_step;

constexpr double infinite = std::numeric_limits<double>::infinity();

void check(const BodyRegion& region) {
  const auto refuse = [&](const std::string& what) { throw GuardError("body region '" + region.name + "': " + what); };
  if (region.name.empty() || region.name.size() >= BodyExcess::name_bytes)
    refuse("its name must have 1 to " + std::to_string(BodyExcess::name_bytes - 1) + " bytes");
  if (region.cells.empty()) refuse("no cell can meet it");
  for (const double limit :
       {region.force.transient, region.force.quasi_static, region.pressure.transient, region.pressure.quasi_static})
    if (!(limit > 0)) refuse("limit " + std::to_string(limit) + " must be greater than 0");
  if (!(region.transient_s >= 0) || !std::isfinite(region.transient_s))
    refuse("transient_s " + std::to_string(region.transient_s) + " must be finite and at least 0");
}

}  // namespace

double cell_area_cm2() noexcept {
  constexpr double side_cm = RS_HEXAGON_SIDE_UM * 1e-4;
  return 1.5 * std::numbers::sqrt3 * side_cm * side_cm;
}

std::string text_of(const BodyExcess& excess) {
  const auto number = [](double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.1f", value);
    return std::string(text.data());
  };
  const std::string kind = excess.transient ? "transient" : "quasi-static";
  const std::string region = "region '" + std::string(excess.region.data()) + "': ";
  switch (excess.quantity) {
    case BodyQuantity::none:
      return "";
    case BodyQuantity::force:
      return region + "the " + kind + " force is " + number(excess.value) + " N, its limit " + number(excess.limit) +
             " N";
    case BodyQuantity::pressure:
      return region + "the " + kind + " pressure is " + number(excess.value) + " N/cm², its limit " +
             number(excess.limit) + " N/cm²";
    case BodyQuantity::saturated:
      if (!std::isfinite(excess.value)) return region + "the force is not known, a sensor's is no finite number";
      return region + "the force is not known, a sensor is at the end of its range with " + number(excess.value) + " N";
    case BodyQuantity::silent:
      return region + "the force is not known, " + number(100 * excess.value) + " % of its cells are alive, of " +
             number(100 * excess.limit) + " % needed";
  }
  return "";
}

BodyMonitor::BodyMonitor(BodyLimits limits)
    : limits_(std::move(limits)), touched_since_ns_(limits_.regions.size(), never_ns) {
  for (const BodyRegion& region : limits_.regions) check(region);
  if (!(limits_.silent_n >= 0) || !std::isfinite(limits_.silent_n))
    throw GuardError("body limits: silent_n " + std::to_string(limits_.silent_n) + " must be finite and at least 0");
  if (!(limits_.smallest_alive_share >= 0 && limits_.smallest_alive_share <= 1))
    throw GuardError("body limits: smallest_alive_share " + std::to_string(limits_.smallest_alive_share) +
                     " must lie between 0 and 1");
}

BodyMonitor::Felt BodyMonitor::feel(const BodyRegion& region, const skin::SkinState& skin) const noexcept {
  Felt felt;
  for (const std::size_t cell : region.cells) {
    if (cell >= skin.size() || skin.health[cell] != skin::Health::alive) continue;
    ++felt.alive;
    const auto& force = skin.normal_force[cell];
    const double newton = double{force[0]} + double{force[1]} + double{force[2]};
    const double largest = std::isfinite(newton) ? std::max({force[0], force[1], force[2]}) : infinite;
    if (largest >= end_of_range_n) felt.saturated_n = std::max(felt.saturated_n, largest);
    if (!(newton > limits_.silent_n) || !std::isfinite(newton)) continue;
    felt.force_n += newton;
    felt.largest_cell_n = std::max(felt.largest_cell_n, newton);
  }
  return felt;
}

bool BodyMonitor::within(const skin::SkinState& skin, std::int64_t now_ns, BodyExcess& excess) noexcept {
  excess.quantity = BodyQuantity::none;
  for (std::size_t i = 0; i < limits_.regions.size(); ++i) {
    const BodyRegion& region = limits_.regions[i];
    const Felt felt = feel(region, skin);
    std::int64_t& since_ns = touched_since_ns_[i];
    if (!(felt.force_n > 0))
      since_ns = never_ns;
    else if (since_ns == never_ns || since_ns > now_ns)
      since_ns = now_ns;
    const bool transient = since_ns != never_ns && static_cast<double>(now_ns - since_ns) * 1e-9 < region.transient_s;

    const auto found = [&](BodyQuantity quantity, double value, double limit) {
      if (excess.quantity != BodyQuantity::none) return;
      excess.region.fill(0);
      std::copy_n(region.name.begin(), std::min(region.name.size(), excess.region.size() - 1), excess.region.begin());
      excess.quantity = quantity;
      excess.transient = transient;
      excess.value = value;
      excess.limit = limit;
    };
    const double force_limit = region.force.of(transient), pressure_limit = region.pressure.of(transient);
    const double pressure = felt.largest_cell_n / cell_area_cm2();
    const double alive = static_cast<double>(felt.alive) / static_cast<double>(region.cells.size());
    if (felt.force_n > force_limit) found(BodyQuantity::force, felt.force_n, force_limit);
    if (pressure > pressure_limit) found(BodyQuantity::pressure, pressure, pressure_limit);
    if (felt.saturated_n > 0) found(BodyQuantity::saturated, felt.saturated_n, end_of_range_n);
    if (alive < limits_.smallest_alive_share || felt.alive == 0)
      found(BodyQuantity::silent, alive, limits_.smallest_alive_share);
  }
  return excess.quantity == BodyQuantity::none;
}

}  // namespace robotskin::robot
