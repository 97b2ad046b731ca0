#include "world/network.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <deque>
#include <limits>

#include "robotskin/crc.h"
#include "world/random.hpp"

namespace robotskin::world {
namespace {

constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();
constexpr double frame_us = 1e6 * double{RS_FRAME_BYTES * RS_LINK_BITS_PER_BYTE} / double{RS_LINK_BAUD};
constexpr std::uint32_t wire_event = 0x80000000U, unit_event = 0x40000000U;  // else: a cell wakes

enum Purpose : std::uint64_t { purpose_clock = 11, purpose_wire = 12, purpose_boot = 13, purpose_session = 14 };

bool due(std::uint32_t now_us, std::uint32_t at_us) {
  return static_cast<std::int32_t>(now_us - at_us) >= 0;
}

}  // namespace

struct Network::Cell {
  enum class Power : std::uint8_t { off, starting, on, dead };

  Power power = Power::off;
  bool sampling = false;
  std::uint32_t timer_us = 0, sample_us = 0;
  std::uint32_t clock_start_us = 0;
  double us_per_ns = 1e-3, ns_per_us = 1e3;
  std::int64_t due_ns = never, scheduled_ns = never;
  std::uint64_t boot_key = 0, boots = 0;
  std::uint32_t queue_peak = 0;
  rs_sample sample{};
  rs_cell state{};
  std::uint8_t flash[RS_FLASH_BYTES] = {};

  std::uint32_t clock_us(std::int64_t time_ns) const {
    return clock_start_us +
           static_cast<std::uint32_t>(static_cast<std::uint64_t>(static_cast<double>(time_ns) * us_per_ns));
  }
};

struct Network::Unit {
  std::unique_ptr<rs_section_unit> state = std::make_unique<rs_section_unit>();
  rs_section_unit_config config{};
  std::uint16_t power = 0;
  std::int64_t due_ns = never, scheduled_ns = never;
};

struct Network::Wire {
  const std::uint8_t* frame = nullptr;  // in the sender's state while it is sent
  std::int64_t end_ns = never;
  std::int32_t to = -1;  // the wire that leads back, whose sender is this one's receiver; -1: open end
  bool cut = false;
  double frame_ns = 1e3 * frame_us;
  std::uint64_t key = 0, frames = 0;
};

Network::Network(const Wiring& wiring, const NetworkOptions& options, SampleSource& source, DatagramSink& sink)
    : options_(options), source_(source), sink_(sink), cells_(wiring.cell_count()), units_(wiring.units.size()) {
  const std::size_t cell_wires = RS_PORTS * cells_.size();
  wires_.resize(cell_wires + RS_SECTION_UNIT_PORTS_MAX * units_.size());
  const auto join = [this](std::size_t a, std::size_t b) {
    wires_[a].to = static_cast<std::int32_t>(b);
    wires_[b].to = static_cast<std::int32_t>(a);
  };
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
      if (end.cell >= 0) join(cell_wires + RS_SECTION_UNIT_PORTS_MAX * u + p, RS_PORTS * end.cell + end.port - 1);
    }
  }
  for (std::size_t w = 0; w < wires_.size(); ++w) wires_[w].key = stream_key(options.seed, purpose_wire, w);

  for (std::size_t i = 0; i < cells_.size(); ++i) {
    Cell& cell = cells_[i];
    const std::uint64_t key = stream_key(options.seed, purpose_clock, i);
    const double rate = 1 + 1e-6 * random_symmetric(key, 0, options.line.clock_drift_ppm);
    cell.us_per_ns = 1e-3 * rate;
    cell.ns_per_us = 1e3 / rate;
    cell.clock_start_us = static_cast<std::uint32_t>(random_bits(key, 1));
    cell.boot_key = stream_key(options.seed, purpose_boot, i);
    for (int p = 0; p < RS_PORTS; ++p) wires_[RS_PORTS * i + p].frame_ns = frame_us * cell.ns_per_us;
    if (wiring.id[i] != RS_ID_NONE) {
      rs_settings settings;
      rs_settings_default(&settings);
      settings.id = wiring.id[i];
      rs_settings_store(&settings, cell.flash);
    }
  }
  if (options.key) hash_.emplace(*options.key);
  queue_.reserve(4 * wires_.size() + 64);

  for (std::size_t u = 0; u < units_.size(); ++u) {
    const UnitDescription& description = wiring.units[u];
    std::size_t of_group = 0, place = 0;
    for (std::size_t v = 0; v < units_.size(); ++v) {
      if (wiring.units[v].section_unit != description.section_unit) continue;
      if (v < u) ++place;
      ++of_group;
    }
    const std::size_t ids = (RS_ID_LAST - RS_ID_FIRST + 1) / of_group;
    rs_section_unit_config& config = units_[u].config;
    config.section_unit = description.section_unit;
    config.unit = description.unit;
    config.ports = static_cast<std::uint8_t>(description.ports.size());
    config.first_id = static_cast<std::uint16_t>(RS_ID_FIRST + place * ids);
    config.last_id = static_cast<std::uint16_t>(RS_ID_FIRST + (place + 1) * ids - 1);
    config.batch_us = options.batch_us;
    config.session = static_cast<std::uint32_t>(stream_key(options.seed, purpose_session, u)) | 1U;
    config.powered = options.powered;
    config.unasked = options.unasked;
    config.cell_key = cell_key();
    if (hash_) {
      config.tag = &driver::KeyedHash::hook;
      config.tag_context = &*hash_;
    }
    rs_unit_input boot{};
    boot.kind = RS_UNIT_INPUT_BOOT;
    boot.config = &config;
    step_unit(u, boot);
  }
}

Network::~Network() = default;

const std::uint8_t* Network::cell_key() const {
  return options_.cell_key ? options_.cell_key->data() : nullptr;
}

void Network::log(std::uint64_t word) {
  log_hash_ = (log_hash_ ^ word) * 0x9E3779B97F4A7C15U;
  log_hash_ ^= log_hash_ >> 29;
}

// ---- Stepping the firmware ----

void Network::boot(std::size_t index) {
  Cell& cell = cells_[index];
  cell.power = Cell::Power::on;
  rs_boot boot{};
  boot.uid = static_cast<std::uint32_t>(index) + 1;
  boot.random = static_cast<std::uint32_t>(random_bits(cell.boot_key, cell.boots++));
  boot.flash = cell.flash;
  boot.key = cell_key();
  rs_input input{};
  input.kind = RS_INPUT_BOOT;
  input.boot = &boot;
  step_cell(index, input);
}

void Network::step_cell(std::size_t index, const rs_input& input) {
  Cell& cell = cells_[index];
  rs_output output;
  const std::uint32_t now_us = cell.clock_us(now_ns_);
  rs_cell_step(&cell.state, &input, now_us, &output);
  ++counts_.cell_steps;
  for (std::uint32_t p = 0; p < RS_PORTS; ++p)
    if (output.frame[p] != nullptr) start(static_cast<std::uint32_t>(RS_PORTS * index) + p, output.frame[p]);
  cell.timer_us = output.timer_us;
  cell.sample_us = output.sample_us;
  cell.sampling = output.sampling;
  if (output.flash_changed) std::memcpy(cell.flash, output.flash, RS_FLASH_BYTES);
  const rs_queues& queues = cell.state.queues;
  cell.queue_peak =
      std::max<std::uint32_t>(cell.queue_peak, queues.urgent.count + queues.data.count + queues.slow.count);
  auto delay_us = static_cast<std::int32_t>(output.timer_us - now_us);
  if (output.sampling) delay_us = std::min(delay_us, static_cast<std::int32_t>(output.sample_us - now_us));
  wake_cell(index, now_ns_ + static_cast<std::int64_t>(std::max(delay_us, 1) * cell.ns_per_us) + 1);
}

void Network::step_unit(std::size_t index, const rs_unit_input& input) {
  Unit& unit = units_[index];
  rs_unit_output output;
  rs_section_unit_step(unit.state.get(), &input, static_cast<std::uint64_t>(options_.epoch_ns + now_ns_), &output);
  const auto first_wire = static_cast<std::uint32_t>(RS_PORTS * cells_.size() + RS_SECTION_UNIT_PORTS_MAX * index);
  for (std::uint32_t p = 0; p < unit.config.ports; ++p)
    if (output.frame[p] != nullptr) start(first_wire + p, output.frame[p]);
  if (output.datagram != nullptr) {
    ++counts_.datagrams;
    counts_.datagram_bytes += output.datagram_bytes;
    rs_datagram_header header;
    if (rs_datagram_header_unpack(&header, output.datagram, output.datagram_bytes) == RS_DATAGRAM_OK &&
        header.kind == RS_DATAGRAM_KIND_frames)
      counts_.records += header.count;
    log(static_cast<std::uint64_t>(now_ns_) ^ output.datagram_bytes);
    sink_.send(index, {output.datagram, output.datagram_bytes});
  }
  const auto timer_ns =
      static_cast<std::int64_t>(std::min<std::uint64_t>(output.timer_ns, static_cast<std::uint64_t>(never)));
  wake_unit(index, timer_ns == never ? never : std::max(timer_ns - options_.epoch_ns, now_ns_));
  if (output.power != unit.power) {
    unit.power = output.power;
    supply();
  }
}

void Network::wake_cell(std::size_t index, std::int64_t time_ns) {
  Cell& cell = cells_[index];
  cell.due_ns = time_ns;
  if (time_ns < cell.scheduled_ns) queue_.push(cell.scheduled_ns = time_ns, static_cast<std::uint32_t>(index));
}

void Network::wake_unit(std::size_t index, std::int64_t time_ns) {
  Unit& unit = units_[index];
  unit.due_ns = time_ns;
  if (time_ns < unit.scheduled_ns)
    queue_.push(unit.scheduled_ns = time_ns, unit_event | static_cast<std::uint32_t>(index));
}

// ---- Wires ----

void Network::start(std::uint32_t index, const std::uint8_t* frame) {
  Wire& wire = wires_[index];
  wire.frame = frame;
  double duration_ns = wire.frame_ns;
  if (options_.line.jitter_us > 0 && wire.to >= 0)
    duration_ns += 1e3 * options_.line.jitter_us * random_unit(wire.key, 4 * wire.frames);
  ++wire.frames;
  if (wire.to >= 0) ++counts_.frames_sent;
  wire.end_ns = now_ns_ + static_cast<std::int64_t>(duration_ns);
  queue_.push(wire.end_ns, wire_event | index);
}

void Network::finish(std::uint32_t index) {
  Wire& wire = wires_[index];
  wire.end_ns = never;
  const std::uint8_t* frame = wire.frame;
  wire.frame = nullptr;
  std::uint8_t damaged[RS_FRAME_BYTES];
  const auto cell_wires = static_cast<std::uint32_t>(RS_PORTS * cells_.size());

  if (wire.to >= 0) {
    const LineQuality& line = options_.line;
    const std::uint64_t draw = 4 * (wire.frames - 1);
    bool lost = wire.cut || (line.lost_share > 0 && random_unit(wire.key, draw + 1) < line.lost_share);
    if (line.bit_error_rate > 0 && !lost) {
      const double intact = std::exp(double{RS_FRAME_BITS} * std::log1p(-line.bit_error_rate));
      if (random_unit(wire.key, draw + 2) >= intact) {
        std::memcpy(damaged, frame, RS_FRAME_BYTES);
        const std::uint64_t bits = random_bits(wire.key, draw + 3);
        const std::uint64_t flips = 1 + ((bits >> 56) & 1) + ((bits >> 57) & (bits >> 58) & 1);
        for (std::uint64_t k = 0; k < flips; ++k) {
          const std::uint64_t at = ((bits >> (16 * k)) & 0xFFFF) % RS_FRAME_BITS;
          damaged[at / 8] ^= static_cast<std::uint8_t>(1U << (at % 8));
        }
        frame = damaged;
        ++counts_.frames_damaged;
      }
    }
    const auto to = static_cast<std::uint32_t>(wire.to);
    lost = lost || (to < cell_wires && cells_[to / RS_PORTS].power != Cell::Power::on);
    log(static_cast<std::uint64_t>(now_ns_) ^ (static_cast<std::uint64_t>(index) << 40) ^ (lost ? 1U : 0U));
    log((static_cast<std::uint64_t>(rs_load32(frame)) << 32) | rs_load32(frame + 16));
    log((static_cast<std::uint64_t>(rs_load32(frame + 4)) << 32) | (rs_load32(frame + 8) ^ rs_load32(frame + 12)));
    if (lost) {
      ++counts_.frames_lost;
    } else if (to < cell_wires) {
      ++counts_.frames_delivered;
      rs_input input{};
      input.kind = RS_INPUT_FRAME;
      input.port = static_cast<std::uint8_t>(to % RS_PORTS + 1);
      input.frame = frame;
      step_cell(to / RS_PORTS, input);
    } else {
      ++counts_.frames_delivered;
      rs_unit_input input{};
      input.kind = RS_UNIT_INPUT_FRAME;
      input.port = static_cast<std::uint8_t>((to - cell_wires) % RS_SECTION_UNIT_PORTS_MAX + 1);
      input.bytes = frame;
      step_unit((to - cell_wires) / RS_SECTION_UNIT_PORTS_MAX, input);
    }
  }

  if (index < cell_wires) {
    if (cells_[index / RS_PORTS].power != Cell::Power::on) return;
    rs_input input{};
    input.kind = RS_INPUT_SENT;
    input.port = static_cast<std::uint8_t>(index % RS_PORTS + 1);
    step_cell(index / RS_PORTS, input);
  } else {
    rs_unit_input input{};
    input.kind = RS_UNIT_INPUT_SENT;
    input.port = static_cast<std::uint8_t>((index - cell_wires) % RS_SECTION_UNIT_PORTS_MAX + 1);
    step_unit((index - cell_wires) / RS_SECTION_UNIT_PORTS_MAX, input);
  }
}

void Network::run_until(std::int64_t end_ns) {
  Event event;
  while (queue_.pop_before(end_ns, event)) {
    now_ns_ = event.time_ns;
    ++counts_.events;
    if ((event.what & wire_event) != 0) {
      const std::uint32_t wire = event.what & ~wire_event;
      if (wires_[wire].end_ns == now_ns_) finish(wire);
    } else if ((event.what & unit_event) != 0) {
      const std::size_t index = event.what & ~unit_event;
      Unit& unit = units_[index];
      if (unit.scheduled_ns != now_ns_) continue;
      unit.scheduled_ns = never;
      if (unit.due_ns > now_ns_) {
        if (unit.due_ns != never) wake_unit(index, unit.due_ns);
        continue;
      }
      rs_unit_input input{};
      input.kind = RS_UNIT_INPUT_TIMER;
      step_unit(index, input);
    } else {
      const std::size_t index = event.what;
      Cell& cell = cells_[index];
      if (cell.scheduled_ns != now_ns_) continue;
      cell.scheduled_ns = never;
      if (cell.due_ns > now_ns_) {
        if (cell.due_ns != never) wake_cell(index, cell.due_ns);
        continue;
      }
      if (cell.power == Cell::Power::starting) {
        boot(index);
      } else if (cell.power == Cell::Power::on) {
        const std::uint32_t now_us = cell.clock_us(now_ns_);
        rs_input input{};
        input.kind = RS_INPUT_TIMER;
        if (cell.sampling && due(now_us, cell.sample_us)) {
          input.kind = RS_INPUT_SAMPLE;
          input.fault = source_.sample(index, now_ns_, cell.sample);
          input.sample = &cell.sample;
        }
        step_cell(index, input);
      }
    }
  }
  now_ns_ = std::max(now_ns_, end_ns);
}

void Network::receive(std::size_t unit, std::span<const std::uint8_t> datagram) {
  rs_unit_input input{};
  input.kind = RS_UNIT_INPUT_DATAGRAM;
  input.bytes = datagram.data();
  input.count = static_cast<std::uint32_t>(datagram.size());
  log(static_cast<std::uint64_t>(now_ns_) ^ (datagram.size() << 48) ^ unit);
  step_unit(unit, input);
}

// ---- Power and faults ----

void Network::supply() {
  std::vector<bool> fed(cells_.size());
  std::deque<std::size_t> next;
  const auto feed = [&](std::int32_t to) {
    if (to < 0 || static_cast<std::size_t>(to) >= RS_PORTS * cells_.size()) return;
    const std::size_t cell = static_cast<std::size_t>(to) / RS_PORTS;
    if (fed[cell]) return;
    fed[cell] = true;
    next.push_back(cell);
  };
  const auto carries = [this](const Wire& wire) { return wire.to >= 0 && !(wire.cut && wires_[wire.to].cut); };
  for (std::size_t u = 0; u < units_.size(); ++u)
    for (std::size_t p = 0; p < units_[u].config.ports; ++p) {
      const Wire& wire = wires_[RS_PORTS * cells_.size() + RS_SECTION_UNIT_PORTS_MAX * u + p];
      if ((units_[u].power >> p & 1) != 0 && carries(wire)) feed(wire.to);
    }
  while (!next.empty()) {
    const std::size_t cell = next.front();
    next.pop_front();
    for (std::size_t p = 0; p < RS_PORTS; ++p)
      if (carries(wires_[RS_PORTS * cell + p])) feed(wires_[RS_PORTS * cell + p].to);
  }
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    Cell& cell = cells_[i];
    if (fed[i] && cell.power == Cell::Power::off) {
      cell.power = Cell::Power::starting;
      const double delay_us = options_.line.power_up_spread_us * random_unit(cell.boot_key, 1U << 20 | cell.boots);
      wake_cell(i, now_ns_ + static_cast<std::int64_t>(1e3 * delay_us));
    } else if (!fed[i] && (cell.power == Cell::Power::on || cell.power == Cell::Power::starting)) {
      kill(i);
      cell.power = Cell::Power::off;
    }
  }
}

void Network::cut(std::size_t cell, int port, bool out, bool in) {
  Wire& wire = wires_.at(RS_PORTS * cell + port - 1);
  if (wire.to < 0) return;
  wire.cut = wire.cut || out;
  wires_[wire.to].cut = wires_[wire.to].cut || in;
  supply();
}

void Network::mend(std::size_t cell, int port) {
  Wire& wire = wires_.at(RS_PORTS * cell + port - 1);
  if (wire.to < 0) return;
  wire.cut = wires_[wire.to].cut = false;
  supply();
}

void Network::kill(std::size_t index) {
  Cell& cell = cells_.at(index);
  cell.power = Cell::Power::dead;
  cell.due_ns = never;
  for (std::size_t p = 0; p < RS_PORTS; ++p) wires_[RS_PORTS * index + p].end_ns = never;
}

void Network::reboot(std::size_t index, std::int64_t off_ns) {
  kill(index);
  cells_[index].power = Cell::Power::starting;
  wake_cell(index, now_ns_ + std::max<std::int64_t>(off_ns, 1));
}

// ---- What is so ----

std::size_t Network::cell_count() const {
  return cells_.size();
}

std::size_t Network::unit_count() const {
  return units_.size();
}

const rs_cell& Network::cell(std::size_t index) const {
  return cells_.at(index).state;
}

bool Network::alive(std::size_t cell) const {
  return cells_.at(cell).power == Cell::Power::on;
}

const rs_section_unit& Network::unit(std::size_t index) const {
  return *units_.at(index).state;
}

std::uint64_t Network::frames_dropped() const {
  std::uint64_t sum = 0;
  for (const Cell& cell : cells_) sum += cell.state.counts.frames_dropped;
  for (const Unit& unit : units_) sum += unit.state->dropped;
  return sum;
}

std::vector<std::uint32_t> Network::queue_peaks() const {
  std::vector<std::uint32_t> peaks;
  for (const Cell& cell : cells_) peaks.push_back(cell.queue_peak);
  return peaks;
}

std::vector<std::int32_t> Network::depths() const {
  std::vector<std::int32_t> depth(cells_.size(), -1);
  std::deque<std::size_t> next;
  const auto reach = [&](const Wire& wire, std::int32_t hops) {
    if (wire.to < 0 || static_cast<std::size_t>(wire.to) >= RS_PORTS * cells_.size()) return;
    if (wire.cut || wires_[wire.to].cut) return;
    const std::size_t cell = static_cast<std::size_t>(wire.to) / RS_PORTS;
    if (!alive(cell) || depth[cell] >= 0) return;
    depth[cell] = hops;
    next.push_back(cell);
  };
  for (std::size_t u = 0; u < units_.size(); ++u)
    for (std::size_t p = 0; p < units_[u].config.ports; ++p)
      if ((units_[u].power >> p & 1) != 0)
        reach(wires_[RS_PORTS * cells_.size() + RS_SECTION_UNIT_PORTS_MAX * u + p], 1);
  while (!next.empty()) {
    const std::size_t cell = next.front();
    next.pop_front();
    for (std::size_t p = 0; p < RS_PORTS; ++p) reach(wires_[RS_PORTS * cell + p], depth[cell] + 1);
  }
  return depth;
}

bool Network::formed() const {
  const std::vector<std::int32_t> depth = depths();
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const Cell& cell = cells_[i];
    if (cell.power == Cell::Power::starting) return false;
    if (depth[i] < 0) continue;
    if (cell.state.route.parent_port == RS_NO_PARENT || cell.state.route.hops != depth[i]) return false;
    if (cell.state.id == RS_ID_NONE) return false;
  }
  return true;
}

}  // namespace robotskin::world
