#include "campaign/fault_case.hpp"

#include <algorithm>
#include <cmath>

#include "campaign/ground.hpp"

namespace robotskin::campaign {
namespace {

constexpr std::uint64_t purpose_case = 41;
constexpr std::int64_t after_ns = 300 * ms, long_after_ns = 1200 * ms;

}  // namespace

std::int64_t end_of(const std::vector<world::Fault>& faults) {
  std::int64_t end_ns = 0;
  for (const world::Fault& fault : faults) {
    std::int64_t lasts_ns = fault.lasts_ns;
    if (fault.kind == world::FaultKind::flap) lasts_ns = fault.count * fault.by_ns;
    end_ns = std::max(end_ns, fault.time_ns + lasts_ns);
  }
  return end_ns;
}

FaultCase draw_case(std::uint64_t seed) {
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
  for (std::int32_t asked = cells;; asked += 4) {
    drawn.wiring = draw_shape(drawn.shape, asked, draw);
    if (drawn.wiring.cell_count() >= 20) break;
  }
  plug_cables(drawn.wiring, units, ports, draw);
  while (drawn.wiring.cell_count() > 400) {
    drawn.wiring = draw_shape(drawn.shape, 380, draw);
    plug_cables(drawn.wiring, units, ports, draw);
  }

  world::NetworkOptions& options = drawn.options;
  options.seed = seed;
  options.unasked = true;
  drawn.keyed = draw.below(2) == 0;
  if (drawn.keyed) {
    options.cell_key.emplace();
    for (std::uint8_t& byte : *options.cell_key) byte = static_cast<std::uint8_t>(draw.below(256));
  }
  options.line.jitter_us = static_cast<double>(std::array{0, 1, 5, 15}[draw.below(4)]);
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
  drawn.duration_ns = end_of(drawn.faults) + (draw.below(40) == 0 ? long_after_ns : after_ns);
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
         (whole_lines ? "" : ", lossy") + ": " + world::to_string(faults);
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
    const bool names_cell_to = fault.kind == world::FaultKind::plug || fault.kind == world::FaultKind::twin;
    if (fault.cell >= 0 && (fault.cell = number[static_cast<std::size_t>(fault.cell)]) < 0) continue;
    if (names_cell_to && fault.to >= 0 && (fault.to = number[static_cast<std::size_t>(fault.to)]) < 0) continue;
    fewer.faults.push_back(fault);
  }
  return fewer;
}

}  // namespace robotskin::campaign
