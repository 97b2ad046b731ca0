// SPDX-License-Identifier: Apache-2.0
#include "campaign/fault_case.hpp"

#include <algorithm>
#include <cmath>

#include "campaign/ground_truth.hpp"

namespace robotskin::campaign {
namespace {

constexpr std::uint64_t purpose_case = 41, purpose_workload = 42;
constexpr std::int64_t after_ns = 300 * ms, long_after_ns = 1300 * ms;

std::int32_t depth_of(const world::Wiring& wiring) {
  std::vector<std::int32_t> depth(wiring.cell_count(), -1);
  std::vector<std::size_t> queue;
  const auto enter = [&](std::int32_t cell, std::int32_t hops) {
    if (cell < 0 || depth[static_cast<std::size_t>(cell)] >= 0) return;
    depth[static_cast<std::size_t>(cell)] = hops;
    queue.push_back(static_cast<std::size_t>(cell));
  };
  for (const world::UnitDescription& unit : wiring.units)
    for (const world::CellEnd end : unit.ports) enter(end.cell, 1);
  for (std::size_t at = 0; at < queue.size(); ++at)
    for (const world::CellEnd end : wiring.neighbours[queue[at]]) enter(end.cell, depth[queue[at]] + 1);
  return queue.empty() ? 0 : depth[queue.back()];
}

// A port carries 20 000 frames of 50 us a second. 4 us of jitter make them 52 us long on the average, a clock 2 % slow
// 53: 18 850 a second. Control may take 6 % of that, and torques a frame an epoch for each limb: with four limbs that
// leaves 16 720, and 66 cells at 250 Hz send 16 500. What is drawn stays within this.
constexpr std::array jitters_us{0, 1, 2, 4};
constexpr std::int32_t limbs_max = 4;
// 66 cells of which 60 % are touched send 39 600 events a second at 1 kHz, twice what their cable carries. What is
// given up then is counted.
constexpr std::array events_hz{250, 1000};
constexpr std::array touched_percents{5, 20, 50, 60};

Workload draw_workload(std::size_t cells, world::RandomStream& draw) {
  Workload workload;
  workload.events = draw.below(3) == 0;
  if (workload.events) workload.touched_percent = touched_percents[draw.below(touched_percents.size())];
  const auto limbs = static_cast<std::int32_t>((cells + cells_per_limb - 1) / cells_per_limb);
  if (draw.below(3) == 0) workload.limbs = std::min(limbs + static_cast<std::int32_t>(draw.below(2)), limbs_max);
  if (limbs > limbs_max) workload.limbs = 0;
  workload.orders = draw.below(3) == 0;
  return workload;
}

}  // namespace

std::int64_t end_of(const std::vector<world::Fault>& faults) {
  std::int64_t end_ns = 0;
  for (const world::Fault& fault : faults) {
    end_ns = std::max(end_ns, fault.time_ns + world::duration_ns(fault));
  }
  return end_ns;
}

std::optional<rs_settings> settings_of(const Workload& workload) {
  if (!workload.events) return std::nullopt;
  rs_settings settings;
  rs_settings_default(&settings);
  settings.mode = RS_MODE_EVENT;
  settings.event_rate_hz = static_cast<std::uint16_t>(workload.events_hz);
  settings.event_mask = 1U << RS_CHANNEL_acceleration_z;
  return settings;
}

FaultCase draw_case(std::uint64_t seed, bool ideal_processors) {
  world::RandomStream draw(world::stream_key(seed, purpose_case, 0));
  FaultCase drawn;
  drawn.seed = seed;
  // As many small skins as large ones on a scale of ratios: most of what can go wrong is local.
  const double share = static_cast<double>(draw.below(10000)) / 10000;
  const auto cells = static_cast<std::int32_t>(std::lround(20 * std::pow(20.0, share)));
  drawn.shape = static_cast<Shape>(draw.below(shape_count));
  const auto ports = static_cast<std::int32_t>(2 + draw.below(4));
  const auto units = static_cast<std::int32_t>(1 + draw.below(static_cast<std::uint64_t>(std::min(ports, 3))));
  // What chance took away is drawn again larger; no case has more than 400.
  for (std::int32_t asked = cells;; asked += asked < 380 ? 4 : 0) {
    drawn.wiring = draw_shape(drawn.shape, asked, draw);
    plug_cables(drawn.wiring, units, ports, draw);
    const std::size_t count = drawn.wiring.cell_count();
    if (count > 400) asked = 376;
    if (count >= 20 && count <= 400 && drawn.ports() >= 2 && depth_of(drawn.wiring) <= hops_max) break;
  }
  drawn.workload = draw_workload(drawn.wiring.cell_count(), draw);
  world::RandomStream draw_more(world::stream_key(seed, purpose_workload, 0));
  drawn.workload.touch = drawn.workload.orders && drawn.workload.limbs == 0 && draw_more.below(2) == 0;
  if (drawn.workload.events) drawn.workload.events_hz = events_hz[draw_more.below(events_hz.size())];

  world::NetworkOptions& options = drawn.options;
  options.seed = seed;
  options.unasked = true;
  if (!ideal_processors) options.processor = world::Processor::one_wait_state;
  options.settings = settings_of(drawn.workload);
  drawn.keyed = draw.below(2) == 0;
  options.line.jitter_us = static_cast<double>(jitters_us[draw.below(jitters_us.size())]);
  options.line.clock_drift_ppm = draw.below(3) == 0 ? 20000 : 100;
  options.line.unit_skew_us = draw.below(2) == 0 ? 100 : 20;
  options.line.unit_drift_ppm = draw.below(2) == 0 ? 50 : 0;
  if (draw.below(5) == 0) {
    drawn.whole_lines = false;
    options.line.lost_share = std::array{0.0, 1e-4, 1e-3}[draw.below(3)];
    options.line.bit_error_rate = std::array{1e-7, 1e-6, 1e-5}[draw.below(3)];
  }
  // The tick number starts anywhere, and wraps within the run in one case of eight.
  options.epoch_ns = static_cast<std::int64_t>(draw.below(65536)) * ms;
  if (draw.below(8) == 0) options.epoch_ns = (65536 - static_cast<std::int64_t>(draw.below(300))) * ms;

  drawn.while_forming = draw.below(6) == 0;
  const std::int64_t from_ns = drawn.while_forming ? static_cast<std::int64_t>(draw.below(8)) * ms
                                                   : (40 + static_cast<std::int64_t>(draw.below(80))) * ms;
  const auto count = static_cast<std::int32_t>(1 + draw.below(4));
  drawn.faults = world::draw_faults(drawn.wiring, count, from_ns, seed);
  // Without a key nothing forged can be told from what is true.
  for (const world::Fault& fault : drawn.faults)
    drawn.keyed = drawn.keyed || world::type_of(fault).truth.plants != world::FaultTruth::Plants::nothing;
  if (drawn.keyed) {
    options.cell_key.emplace();
    for (std::uint8_t& byte : *options.cell_key) byte = static_cast<std::uint8_t>(draw.below(256));
  }
  // One case in 32 lasts until topology reports have come round.
  drawn.duration_ns = end_of(drawn.faults) + (draw.below(32) == 0 ? long_after_ns : after_ns);
  return drawn;
}

std::size_t FaultCase::ports() const {
  std::size_t plugged = 0;
  for (const world::UnitDescription& unit : wiring.units)
    plugged +=
        static_cast<std::size_t>(std::ranges::count_if(unit.ports, [](world::CellEnd end) { return end.cell >= 0; }));
  return plugged;
}

std::string FaultCase::text() const {
  return "seed " + std::to_string(seed) + ": " + std::string(name_of(shape)) + " of " +
         std::to_string(wiring.cell_count()) + " cells, " + std::to_string(ports()) + " ports on " +
         std::to_string(wiring.units.size()) + " section units" + (keyed ? ", keyed" : "") +
         (whole_lines ? "" : ", lossy") +
         (workload.events ? ", events of " + std::to_string(workload.touched_percent) + " % at " +
                                std::to_string(workload.events_hz) + " Hz"
                          : "") +
         (workload.limbs > 0 ? ", torques of " + std::to_string(workload.limbs) + " limbs" : "") +
         (workload.orders ? ", orders" : "") + (workload.touch ? ", own torques" : "") + ": " +
         world::to_string(faults);
}

FaultCase with_faults(const FaultCase& original, const std::vector<bool>& faults) {
  FaultCase fewer = original;
  fewer.faults.clear();
  for (std::size_t i = 0; i < original.faults.size(); ++i)
    if (faults[i]) fewer.faults.push_back(original.faults[i]);
  return fewer;
}

FaultCase with_cells(const FaultCase& original, const std::vector<bool>& cells) {
  FaultCase fewer = original;
  std::vector<std::int32_t> number(cells.size(), -1);
  std::int32_t next = 0;
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (cells[i]) number[i] = next++;
  const auto renamed = [&](world::CellEnd end) {
    if (end.cell < 0 || number[static_cast<std::size_t>(end.cell)] < 0) return world::CellEnd{};
    return world::CellEnd{number[static_cast<std::size_t>(end.cell)], end.port};
  };
  fewer.wiring.neighbours.clear();
  fewer.wiring.id.clear();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (!cells[i]) continue;
    std::array<world::CellEnd, 4> ends = original.wiring.neighbours[i];
    for (world::CellEnd& end : ends) end = renamed(end);
    fewer.wiring.neighbours.push_back(ends);
    fewer.wiring.id.push_back(original.wiring.id[i]);
  }
  for (world::UnitDescription& unit : fewer.wiring.units)
    for (world::CellEnd& end : unit.ports) end = renamed(end);
  fewer.faults.clear();
  for (world::Fault fault : original.faults) {
    const world::FaultTo to = world::type_of(fault).to;
    const bool names_cell_to = to == world::FaultTo::cell || to == world::FaultTo::cell_or_none;
    if (fault.cell >= 0 && (fault.cell = number[static_cast<std::size_t>(fault.cell)]) < 0) continue;
    if (names_cell_to && fault.to >= 0 && (fault.to = number[static_cast<std::size_t>(fault.to)]) < 0) continue;
    fewer.faults.push_back(fault);
  }
  return fewer;
}

}  // namespace robotskin::campaign
