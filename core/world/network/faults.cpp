// Power and faults: who is fed, and what strikes when.
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <deque>
#include <vector>

#include "robotskin/crc.h"
#include "robotskin/timing.h"
#include "world/network/parts.hpp"
#include "world/random.hpp"

namespace robotskin::world {

void Network::supply() {
  ++topology_revision_;
  std::vector<bool> fed(cells_.size());
  std::deque<std::size_t> next;
  const auto feed = [&](std::int32_t to) {
    if (to < 0 || static_cast<std::size_t>(to) >= cell_wires()) return;
    const std::size_t cell = static_cast<std::size_t>(to) / RS_PORTS;
    if (fed[cell]) return;
    fed[cell] = true;
    next.push_back(cell);
  };
  const auto conducts = [this](const Wire& wire) {
    return wire.to >= 0 && !(wire.severed != 0 && wires_[wire.to].severed != 0);
  };
  for (std::size_t u = 0; u < units_.size(); ++u)
    for (std::size_t p = 0; p < units_[u].config.ports; ++p) {
      const Wire& wire = wires_[cell_wires() + RS_SECTION_UNIT_PORTS_MAX * u + p];
      if (((units_[u].power & ~units_[u].unfed) >> p & 1) != 0 && conducts(wire)) feed(wire.to);
    }
  while (!next.empty()) {
    const std::size_t cell = next.front();
    next.pop_front();
    for (std::size_t p = 0; p < RS_PORTS; ++p)
      if (conducts(wires_[RS_PORTS * cell + p])) feed(wires_[RS_PORTS * cell + p].to);
  }
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    Cell& cell = cells_[i];
    if (fed[i] && cell.power == Cell::Power::off) {
      cell.power = Cell::Power::starting;
      const double delay_us = options_.line.power_up_spread_us * random_unit(cell.boot_key, 1U << 20 | cell.boots);
      wake_cell(i, now_ns_ + static_cast<std::int64_t>(1e3 * delay_us));
    } else if (!fed[i] && cell.power != Cell::Power::off && cell.power != Cell::Power::dead) {
      kill(i);
      cell.power = Cell::Power::off;
    }
  }
}

void Network::cut(std::size_t cell, int port, bool out, bool in) {
  sever(wires_.size() > RS_PORTS * cell ? RS_PORTS * cell + port - 1 : wires_.size(), severed_by_cut, out, in);
}

void Network::mend(std::size_t cell, int port) {
  cut(cell, port, false, false);
}

void Network::kill(std::size_t index) {
  Cell& cell = cells_.at(index);
  ++topology_revision_;
  cell.power = Cell::Power::dead;
  cell.due_ns = never;
  for (std::size_t p = 0; p < RS_PORTS; ++p) wires_[RS_PORTS * index + p].end_ns = never;
  forget_board(index);
}

void Network::reboot(std::size_t index, std::int64_t off_ns) {
  kill(index);
  cells_[index].power = Cell::Power::starting;
  wake_cell(index, now_ns_ + std::max<std::int64_t>(off_ns, 1));
}

// ---- Faults at their times ----

void Network::inject(const Fault& fault) {
  check_fault(fault, wiring_);
  if (fault.time_ns < now_ns_)
    throw FaultError("fault '" + to_string(fault) + "': it is " + std::to_string(now_ns_) + " ns already");
  if (fault.kind == FaultKind::wrap)
    throw FaultError("fault '" + to_string(fault) + "': the clocks are set when a network is built");
  Act& act = acts_.emplace_back(Act{fault, 0, {}});
  if (fault.kind == FaultKind::late) {
    // Not there until then.
    act.wires = wires_around(static_cast<std::size_t>(fault.cell), static_cast<std::size_t>(fault.count));
    for (const std::size_t wire : act.wires) sever(wire, severed_as_late, true, true);
  }
  if (fault.kind == FaultKind::replay) wires_[wires_of(fault).front()].taped = true;
  queue_.push(fault.time_ns, act_event | static_cast<std::uint32_t>(acts_.size() - 1));
}

void Network::act(std::size_t index) {
  Act& act = acts_[index];
  const Fault fault = act.fault;
  const int phase = act.phase++;
  log(static_cast<std::uint64_t>(now_ns_) ^ (static_cast<std::uint64_t>(index) << 48) ^ static_cast<unsigned>(phase));
  if (is_attack(fault.kind)) {
    attack(act, phase);
  } else if (phase % 2 == 0) {
    begin(act);
  } else {
    end(act);
  }
  std::int64_t next_ns = never;
  if (is_attack(fault.kind)) {
    if (phase + 1 < fault.count) next_ns = now_ns_ + fault.by_ns;
  } else if (fault.kind == FaultKind::flap) {
    if (phase + 1 < 2 * fault.count) next_ns = now_ns_ + fault.by_ns / 2;
  } else if (phase == 0 && fault.lasts_ns > 0 && fault.kind != FaultKind::reboot && fault.kind != FaultKind::twin) {
    next_ns = now_ns_ + fault.lasts_ns;
  }
  if (next_ns != never) queue_.push(next_ns, act_event | static_cast<std::uint32_t>(index));
  tell([&](Observer& observer) { observer.fault_applied(*this, fault, phase); });
}

void Network::begin(Act& act) {
  const Fault& fault = act.fault;
  const auto cell = static_cast<std::size_t>(fault.cell), unit = static_cast<std::size_t>(fault.unit);
  switch (fault.kind) {
    case FaultKind::cut:
    case FaultKind::flap:
      for (const std::size_t wire : wires_of(fault)) sever(wire, severed_by_cut, true, true);
      break;
    case FaultKind::mend:
      for (const std::size_t wire : wires_of(fault)) sever(wire, severed_by_cut, false, false);
      break;
    case FaultKind::oneway:
      for (const std::size_t wire : wires_of(fault))
        sever(wire, severed_by_cut, fault.way == FaultWay::out, fault.way == FaultWay::in);
      break;
    case FaultKind::noise:
    case FaultKind::burst:
      act.wires = troubled_by(fault);
      trouble(act, true);
      break;
    case FaultKind::slow:
      cells_[cell].slow_ns = fault.by_ns;
      break;
    case FaultKind::zombie:
      if (cells_[cell].power != Cell::Power::on) break;
      ++topology_revision_;
      cells_[cell].power = Cell::Power::zombie;
      wake_cell(cell, now_ns_ + RS_TICK_US * 1000);
      break;
    case FaultKind::crash:
      if (cells_[cell].power != Cell::Power::off) kill(cell);
      break;
    case FaultKind::reboot:
      if (cells_[cell].power != Cell::Power::off) reboot(cell, fault.lasts_ns);
      break;
    case FaultKind::ram:
      if (cells_[cell].power == Cell::Power::on)
        corrupt(fault, stream_key(options_.seed, purpose_act, static_cast<std::uint64_t>(&act - acts_.data())));
      break;
    case FaultKind::stuff:
      if (cells_[cell].power == Cell::Power::on) stuff(fault);
      break;
    case FaultKind::twin:
      rename(cell, cells_[static_cast<std::size_t>(fault.to)].state.id);
      if (cells_[cell].power != Cell::Power::off) reboot(cell, fault.lasts_ns);
      break;
    case FaultKind::plug: {
      const std::size_t wire =
          wire_of({WireEnd::At::cell, static_cast<std::uint8_t>(fault.port), static_cast<std::uint32_t>(fault.cell)});
      act.wires = {wire};
      if (wires_[wire].to >= 0) act.wires.push_back(static_cast<std::size_t>(wires_[wire].to));
      part(wire);
      if (fault.to >= 0) {
        const std::size_t to = wire_of(
            {WireEnd::At::cell, static_cast<std::uint8_t>(fault.to_port), static_cast<std::uint32_t>(fault.to)});
        part(to);
        if (to != wire) join(wire, to);
      }
      supply();
      break;
    }
    case FaultKind::late:
      for (const std::size_t wire : act.wires) sever(wire, severed_as_late, false, false);
      break;
    case FaultKind::drift:
      if (fault.cell >= 0) {
        set_drift(cell, fault.amount);
      } else {
        units_[unit].set_drift(now_ns_, 1e-6 * fault.amount);
        wake_unit(unit, now_ns_);
      }
      break;
    case FaultKind::skew:
      units_[unit].ahead_ns += fault.by_ns;
      wake_unit(unit, now_ns_);
      break;
    case FaultKind::stop:
      ++topology_revision_;
      units_[unit].stopped = true;
      for (std::size_t p = 0; p < RS_SECTION_UNIT_PORTS_MAX; ++p)
        wires_[cell_wires() + RS_SECTION_UNIT_PORTS_MAX * unit + p].end_ns = never;
      break;
    case FaultKind::power:
      units_[unit].unfed |= static_cast<std::uint16_t>(1U << (fault.port - 1));
      supply();
      break;
    case FaultKind::delay:
    case FaultKind::loss:
    case FaultKind::partition:
      trouble_ethernet(fault, true);
      break;
    case FaultKind::forge:
    case FaultKind::replay:
    case FaultKind::wrap:
      break;
  }
}

void Network::end(Act& act) {
  const Fault& fault = act.fault;
  const auto cell = static_cast<std::size_t>(fault.cell), unit = static_cast<std::size_t>(fault.unit);
  switch (fault.kind) {
    case FaultKind::cut:
    case FaultKind::flap:
    case FaultKind::oneway:
      for (const std::size_t wire : wires_of(fault)) sever(wire, severed_by_cut, false, false);
      break;
    case FaultKind::noise:
    case FaultKind::burst:
      trouble(act, false);
      break;
    case FaultKind::slow:
      cells_[cell].slow_ns = 0;
      break;
    case FaultKind::zombie:
      if (cells_[cell].power != Cell::Power::zombie) break;
      ++topology_revision_;
      cells_[cell].power = Cell::Power::on;
      report_idle_wires(cell);
      break;
    case FaultKind::plug:
      part(act.wires.front());
      if (act.wires.size() == 2) {
        part(act.wires.back());
        join(act.wires.front(), act.wires.back());
      }
      supply();
      break;
    case FaultKind::drift:
      if (fault.cell >= 0) {
        set_drift(cell, 0);
      } else {
        units_[unit].set_drift(now_ns_, 0);
        wake_unit(unit, now_ns_);
      }
      break;
    case FaultKind::stop:
      if (!units_[unit].stopped) break;
      ++topology_revision_;
      boot_unit(unit);
      break;
    case FaultKind::power:
      units_[unit].unfed &= static_cast<std::uint16_t>(~(1U << (fault.port - 1)));
      supply();
      break;
    case FaultKind::delay:
    case FaultKind::loss:
    case FaultKind::partition:
      trouble_ethernet(fault, false);
      break;
    default:
      break;
  }
}

// ---- Wires ----

std::vector<std::size_t> Network::wires_of(const Fault& fault) const {
  std::vector<std::size_t> wires;
  if (fault.cell < 0 && fault.unit < 0) {
    for (std::size_t w = 0; w < wires_.size(); ++w) wires.push_back(w);
    return wires;
  }
  const bool of_cell = fault.cell >= 0;
  const int ports = of_cell ? int{RS_PORTS} : int{RS_SECTION_UNIT_PORTS_MAX};
  for (int port = 1; port <= ports; ++port)
    if (fault.port == 0 || fault.port == port)
      wires.push_back(wire_of({of_cell ? WireEnd::At::cell : WireEnd::At::unit, static_cast<std::uint8_t>(port),
                               static_cast<std::uint32_t>(of_cell ? fault.cell : fault.unit)}));
  return wires;
}

void Network::sever(std::size_t index, std::uint8_t why, bool out, bool in) {
  Wire& wire = wires_.at(index);
  if (wire.to < 0) return;
  Wire& back = wires_[static_cast<std::size_t>(wire.to)];
  const bool mends = !out && !in;
  for (Wire* way : {&wire, &back}) {
    if (mends) {
      way->severed &= static_cast<std::uint8_t>(~why);
    } else if (way == &wire ? out : in) {
      way->severed |= why;
      way->torn = way->end_ns != never;
    }
  }
  supply();
}

// Both ways of every wire it names.
std::vector<std::size_t> Network::troubled_by(const Fault& fault) const {
  std::vector<std::size_t> wires = wires_of(fault);
  if (fault.cell < 0 && fault.unit < 0) return wires;
  for (std::size_t i = 0, named = wires.size(); i < named; ++i)
    if (wires_[wires[i]].to >= 0) wires.push_back(static_cast<std::size_t>(wires_[wires[i]].to));
  return wires;
}

// It ends where it began, even if a plug has been moved meanwhile.
void Network::trouble(const Act& act, bool begins) {
  troubles_.resize(wires_.size());
  const Fault& fault = act.fault;
  const double by = begins ? fault.amount : -fault.amount;
  for (const std::size_t wire : act.wires) {
    wires_[wire].troubled = true;
    if (fault.kind == FaultKind::noise)
      troubles_[wire].bit_error_rate = std::max(0.0, troubles_[wire].bit_error_rate + by);
    if (fault.kind == FaultKind::burst) troubles_[wire].lost_share = std::max(0.0, troubles_[wire].lost_share + by);
  }
}

// The wires between a connected group of cells, the nearest to `cell`, and the rest.
std::vector<std::size_t> Network::wires_around(std::size_t cell, std::size_t size) const {
  std::vector<std::size_t> group{cell};
  std::vector<bool> inside(cells_.size());
  inside[cell] = true;
  const auto neighbour = [this](std::size_t of, std::size_t p) {
    const std::int32_t to = wires_[RS_PORTS * of + p].to;
    return to < 0 || static_cast<std::size_t>(to) >= cell_wires() ? cells_.size()
                                                                  : static_cast<std::size_t>(to) / RS_PORTS;
  };
  for (std::size_t i = 0; i < group.size(); ++i)
    for (std::size_t p = 0; p < RS_PORTS && group.size() < size; ++p) {
      const std::size_t next = neighbour(group[i], p);
      if (next == cells_.size() || inside[next]) continue;
      inside[next] = true;
      group.push_back(next);
    }
  std::vector<std::size_t> wires;
  for (const std::size_t i : group)
    for (std::size_t p = 0; p < RS_PORTS; ++p) {
      const std::size_t next = neighbour(i, p);
      if (wires_[RS_PORTS * i + p].to >= 0 && (next == cells_.size() || !inside[next]))
        wires.push_back(RS_PORTS * i + p);
    }
  return wires;
}

// ---- Cells ----

void Network::set_drift(std::size_t index, double ppm) {
  Cell& cell = cells_[index];
  const std::uint32_t shown_us = cell.clock_us(now_ns_);
  const double rate = 1 + 1e-6 * ppm;
  cell.us_per_ns = 1e-3 * rate;
  cell.ns_per_us = 1e3 / rate;
  cell.clock_start_us += shown_us - cell.clock_us(now_ns_);
}

// The stuck processor's link hardware sends the advert it was given last, again and again.
void Network::haunt(std::size_t index) {
  Cell& cell = cells_[index];
  const rs_route& route = cell.state.route;
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    Wire& wire = wires_[RS_PORTS * index + port];
    if (wire.end_ns != never) continue;
    rs_tick tick{};
    tick.type = RS_TYPE_tick;
    tick.hops = route.hops;
    tick.sender = cell.state.id;
    tick.sender_port = port;
    tick.nonce = cell.state.nonce;
    tick.parent = route.parent_port == port + 1U ? 1 : 0;
    tick.heard = route.neighbour[port].up ? 1 : 0;
    rs_wave_into_tick(&tick, &route.wave);
    std::uint8_t* frame = cell.state.queues.sending[port];
    rs_tick_pack(frame, &tick);
    rs_frame_seal(frame);
    start(static_cast<std::uint32_t>(RS_PORTS * index + port), frame, now_ns_);
  }
  wake_cell(index, now_ns_ + RS_TICK_US * 1000);
}

// Which ports are free is known to the link hardware, whatever the processor's memory says.
void Network::report_idle_wires(std::size_t index) {
  for (std::size_t p = 0; p < RS_PORTS; ++p) {
    if (!takes_frame(RS_PORTS * index + p)) continue;
    rs_input input{};
    input.kind = RS_INPUT_SENT;
    input.port = static_cast<std::uint8_t>(p + 1);
    step_cell(index, input);
  }
}

void Network::rename(std::size_t index, std::uint16_t id) {
  rs_settings settings;
  rs_settings_load(&settings, cells_[index].flash);
  settings.id = id;
  rs_settings_store(&settings, cells_[index].flash);
}

void Network::stuff(const Fault& fault) {
  rs_clock sample{};
  sample.type = RS_TYPE_clock;
  sample.source = RS_ID_NONE;
  sample.ttl = RS_TTL_START;
  std::uint8_t frame[RS_FRAME_BYTES];
  for (std::int32_t k = 0; k < fault.count; ++k) {
    sample.sequence = static_cast<std::uint32_t>(k) & 0x3U;
    rs_clock_pack(frame, &sample);
    rs_frame_seal(frame);
    rs_input input{};
    input.kind = RS_INPUT_FRAME;
    input.port = static_cast<std::uint8_t>(fault.port);
    input.frame = frame;
    step_cell(static_cast<std::size_t>(fault.cell), input);
  }
}

namespace {

struct Range {
  std::size_t first, bytes;
};

// Where a cell keeps what a part names.
std::vector<Range> ranges_of(FaultPart part) {
  constexpr Range route{offsetof(rs_cell, route), sizeof(rs_route)};
  constexpr Range queues{offsetof(rs_cell, queues), sizeof(rs_queues)};
  constexpr Range sampling{offsetof(rs_cell, sampling), sizeof(rs_sampling)};
  switch (part) {
    case FaultPart::route:
      return {route};
    case FaultPart::queues:
      return {queues};
    case FaultPart::sampling:
      return {sampling};
    case FaultPart::retention:
      return {{offsetof(rs_cell, retention), sizeof(rs_retention)}};
    case FaultPart::torque:
      return {{offsetof(rs_cell, torque), offsetof(rs_cell, retention) - offsetof(rs_cell, torque)}};
    case FaultPart::commands:
      return {{offsetof(rs_cell, commanding), sizeof(rs_commanding)}};
    case FaultPart::settings:
      return {{offsetof(rs_cell, settings), offsetof(rs_cell, counts) - offsetof(rs_cell, settings)}};
    case FaultPart::whole:
      return {{0, sizeof(rs_cell)}};
    case FaultPart::all:
      break;
  }
  return {route, queues, sampling};
}

}  // namespace

void Network::corrupt(const Fault& fault, std::uint64_t key) {
  auto* state = reinterpret_cast<std::uint8_t*>(&cells_[static_cast<std::size_t>(fault.cell)].state);
  const std::vector<Range> ranges = ranges_of(fault.part);
  std::size_t whole = 0;
  for (const Range& range : ranges) whole += range.bytes;
  RandomStream draw(key);
  for (std::int32_t k = 0; k < fault.count; ++k) {
    std::size_t at = draw.below(whole);
    const auto* range = ranges.data();
    for (; at >= range->bytes; ++range) at -= range->bytes;
    state[range->first + at] = static_cast<std::uint8_t>(draw.bits());
  }
  report_idle_wires(static_cast<std::size_t>(fault.cell));
}

}  // namespace robotskin::world
