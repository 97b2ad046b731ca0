// SPDX-License-Identifier: Apache-2.0
// The network as it is built: wires joined, clocks started, ids stored, section units configured.
#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"
#include "world/random.hpp"

namespace robotskin::world {

Network::Network(const Wiring& wiring, const NetworkOptions& options, SampleSource& source, DatagramSink& sink)
    : wiring_(wiring),
      options_(options),
      source_(source),
      sink_(sink),
      wire_keys_(stream_family(options.seed, purpose_wire)),
      cells_(wiring.cell_count()),
      units_(wiring.units.size()) {
  if (takes_time()) boards_.resize(cells_.size());
  wires_.resize(cell_wires() + RS_SECTION_UNIT_PORTS_MAX * units_.size());
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    for (int p = 0; p < RS_PORTS; ++p) {
      const CellEnd end = wiring.neighbours[i][p];
      if (end.cell < 0) continue;
      const CellEnd back = wiring.neighbours[end.cell][end.port - 1];
      if (back.cell == static_cast<std::int32_t>(i) && back.port == p + 1)
        join(RS_PORTS * i + p, RS_PORTS * end.cell + end.port - 1);
    }
  }
  for (std::size_t u = 0; u < units_.size(); ++u) {
    for (std::size_t p = 0; p < wiring.units[u].ports.size(); ++p) {
      const CellEnd end = wiring.units[u].ports[p];
      if (end.cell >= 0) join(cell_wires() + RS_SECTION_UNIT_PORTS_MAX * u + p, RS_PORTS * end.cell + end.port - 1);
    }
  }

  for (std::size_t i = 0; i < cells_.size(); ++i) {
    Cell& cell = cells_[i];
    const std::uint64_t key = stream_key(options.seed, purpose_clock, i);
    const double rate = 1 + 1e-6 * random_symmetric(key, 0, options.line.clock_drift_ppm);
    cell.us_per_ns = 1e-3 * rate;
    cell.ns_per_us = 1e3 / rate;
    cell.clock_start_us = static_cast<std::uint32_t>(random_bits(key, 1));
    cell.boot_key = stream_key(options.seed, purpose_boot, i);
    if (wiring.id[i] != RS_ID_NONE || options.clock_rate_hz != RS_CLOCK_RATE_DEFAULT_HZ || options.settings) {
      rs_settings settings;
      rs_settings_default(&settings);
      settings.clock_rate_hz = options.clock_rate_hz;
      if (options.settings) settings = *options.settings;
      settings.id = wiring.id[i];
      rs_settings_store(&settings, cell.flash);
    }
  }
  if (options.key) hash_.emplace(*options.key);
  find_lanes();
  for (const Fault& fault : options.faults)
    if (const auto at_start = type_of(fault).at_start) at_start(fault, options_);

  for (std::size_t u = 0; u < units_.size(); ++u) {
    const UnitDescription& description = wiring.units[u];
    std::size_t of_group = 0, place = 0;
    for (std::size_t v = 0; v < units_.size(); ++v) {
      if (wiring.units[v].group != description.group) continue;
      if (v < u) ++place;
      ++of_group;
    }
    const std::size_t ids = (RS_ID_LAST - RS_ID_FIRST + 1) / of_group;
    rs_section_unit_config& config = units_[u].config;
    config.group = description.group;
    config.unit = description.unit;
    config.ports = static_cast<std::uint8_t>(description.ports.size());
    config.first_id = static_cast<std::uint16_t>(RS_ID_FIRST + place * ids);
    config.last_id = static_cast<std::uint16_t>(RS_ID_FIRST + (place + 1) * ids - 1);
    config.batch_us = options.batch_us;
    config.session = static_cast<std::uint32_t>(stream_key(options.seed, purpose_session, u)) | 1U;
    config.powered = options.powered;
    config.unasked = options.unasked;
    config.cell_key = cell_key();
    // A simulated clock starts anew with each run.
    config.turns =
        static_cast<std::uint32_t>(stream_key(options.seed, purpose_session, RS_UNITS_MAX) & (RS_TURN_MASK >> 1));
    if (hash_) {
      config.tag = &driver::KeyedHash::hook;
      config.tag_context = &*hash_;
    }
    Unit& unit = units_[u];
    const std::uint64_t clock = stream_key(options.seed, purpose_unit_clock, u);
    unit.ahead_ns = options_.epoch_ns + description.skew_ns +
                    static_cast<std::int64_t>(1e3 * random_symmetric(clock, 0, options.line.unit_skew_us));
    unit.drift = 1e-6 * (description.drift_ppm + random_symmetric(clock, 1, options.line.unit_drift_ppm));
  }
  for (const Fault& fault : options.faults)
    if (type_of(fault).at_start == nullptr) inject(fault);
  for (std::size_t u = 0; u < units_.size(); ++u) boot_unit(u);
}

// ---- Wires ----

void Network::join(std::size_t a, std::size_t b) {
  if (!lanes_.empty() && &lane_of_wire(a) != &lane_of_wire(b)) unite(lane_of_wire(a).number, lane_of_wire(b).number);
  wires_[a].to = static_cast<std::int32_t>(b);
  wires_[b].to = static_cast<std::int32_t>(a);
}

void Network::part(std::size_t wire) {
  if (wires_[wire].to < 0) return;
  for (const std::size_t w : {wire, static_cast<std::size_t>(wires_[wire].to)}) {
    wires_[w].to = -1;
    wires_[w].torn = wires_[w].end_ns != never;
  }
}

std::size_t Network::wire_of(WireEnd end) const {
  return end.at == WireEnd::At::cell ? RS_PORTS * end.index + end.port - 1
                                     : cell_wires() + RS_SECTION_UNIT_PORTS_MAX * end.index + end.port - 1;
}

WireEnd Network::end_of(std::size_t wire) const {
  const auto place = [wire](WireEnd::At at, std::size_t first, std::size_t ports) {
    return WireEnd{at, static_cast<std::uint8_t>((wire - first) % ports + 1),
                   static_cast<std::uint32_t>((wire - first) / ports)};
  };
  return wire < cell_wires() ? place(WireEnd::At::cell, 0, RS_PORTS)
                             : place(WireEnd::At::unit, cell_wires(), RS_SECTION_UNIT_PORTS_MAX);
}

WireEnd Network::other_end(WireEnd end) const {
  const std::int32_t to = wires_.at(wire_of(end)).to;
  return to < 0 ? WireEnd{} : end_of(static_cast<std::size_t>(to));
}

bool Network::carries(WireEnd from) const {
  const Wire& wire = wires_.at(wire_of(from));
  if (wire.to < 0 || wire.severed != 0) return false;
  const WireEnd to = end_of(static_cast<std::size_t>(wire.to));
  return to.at == WireEnd::At::cell ? alive(to.index) : unit_runs(to.index);
}

Network::~Network() = default;

const std::uint8_t* Network::cell_key() const {
  return options_.cell_key ? options_.cell_key->data() : nullptr;
}

}  // namespace robotskin::world
