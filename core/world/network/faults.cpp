// SPDX-License-Identifier: Apache-2.0
// Faults at their times, and what their kinds may do to a network.
#include <algorithm>

#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"
#include "world/random.hpp"

namespace robotskin::world {

void Network::inject(const Fault& fault) {
  check_fault(fault, wiring_);
  if (fault.time_ns < time_ns())
    throw FaultError("fault '" + to_string(fault) + "': it is " + std::to_string(time_ns()) + " ns already");
  const FaultType& type = type_of(fault);
  if (type.at_start != nullptr)
    throw FaultError("fault '" + to_string(fault) + "': the clocks are set when a network is built");
  RunningFault& act = acts_.emplace_back(*this, acts_.size(), fault);
  if (type.await != nullptr) type.await(act);
  plan_act(fault.time_ns, act.number);
}

void Network::plan_act(std::int64_t time_ns, std::size_t index) {
  acts_due_.insert(std::ranges::upper_bound(acts_due_, time_ns, {}, &Event::time_ns),
                   {time_ns, static_cast<std::uint32_t>(index)});
}

void Network::act(std::size_t index) {
  RunningFault& act = acts_[index];
  const Fault fault = act.fault;
  const FaultType& type = type_of(fault);
  const int phase = act.phase++;
  Lane& lane = lane_of(fault);
  const std::int64_t now_ns = lane.now_ns;
  lane.log(static_cast<std::uint64_t>(now_ns) ^ (static_cast<std::uint64_t>(index) << 48) ^
           static_cast<unsigned>(phase));
  if (phase % 2 == 0 || type.course == FaultCourse::repeated) {
    type.begin(act, phase);
  } else if (type.end != nullptr) {
    type.end(act);
  }
  std::int64_t next_ns = never;
  switch (type.course) {
    case FaultCourse::repeated:
      if (phase + 1 < fault.count) next_ns = now_ns + fault.by_ns;
      break;
    case FaultCourse::alternating:
      if (phase + 1 < 2 * fault.count) next_ns = now_ns + fault.by_ns / 2;
      break;
    case FaultCourse::lasting:
      if (phase == 0 && fault.lasts_ns > 0) next_ns = now_ns + fault.lasts_ns;
      break;
    case FaultCourse::momentary:
      break;
  }
  if (next_ns != never) plan_act(next_ns, index);
  tell([&](Observer& observer) { observer.fault_applied(*this, fault, phase); });
}

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
  supply(lane_of_wire(index));
}

// ---- What a kind may do ----

std::uint64_t Network::RunningFault::random_key(std::uint64_t of) const {
  return stream_key(network.options_.seed, purpose_act, of);
}

bool Network::RunningFault::cell_is_on() const {
  return network.cells_[cell_index()].power == Cell::Power::on;
}

bool Network::RunningFault::cell_has_power() const {
  return network.cells_[cell_index()].power != Cell::Power::off;
}

bool Network::RunningFault::cell_is_zombie() const {
  return network.cells_[cell_index()].power == Cell::Power::zombie;
}

void Network::RunningFault::set_zombie(bool zombie) {
  cell().power = zombie ? Cell::Power::zombie : Cell::Power::on;
}

std::size_t Network::RunningFault::wire_at(std::int32_t cell, std::int32_t port) const {
  return network.wire_of({WireEnd::At::cell, static_cast<std::uint8_t>(port), static_cast<std::uint32_t>(cell)});
}

void Network::RunningFault::sever(const std::vector<std::size_t>& which, std::uint8_t why, bool out, bool in) {
  for (const std::size_t index : which) network.sever(index, why, out, in);
}

void Network::RunningFault::take_own_wires_both_ways() {
  wires = own_wires();
  if (fault.cell < 0 && fault.unit < 0) return;
  for (std::size_t i = 0, named = wires.size(); i < named; ++i)
    if (wire(wires[i]).to >= 0) wires.push_back(static_cast<std::size_t>(wire(wires[i]).to));
}

void Network::RunningFault::trouble(double bit_error_rate, double lost_share) {
  network.troubles_.resize(wire_count());
  for (const std::size_t index : wires) {
    wire(index).troubled = true;
    Trouble& at = network.troubles_[index];
    at.bit_error_rate = std::max(0.0, at.bit_error_rate + bit_error_rate);
    at.lost_share = std::max(0.0, at.lost_share + lost_share);
  }
}

// The cell first does what is due, so that what changes then comes from the frame.
void Network::RunningFault::plant(const std::uint8_t* frame) {
  rs_input input{};
  input.kind = RS_INPUT_TIMER;
  step_cell(input);
  if (!cell_is_on()) return;
  const WireEnd to{WireEnd::At::cell, static_cast<std::uint8_t>(fault.port), static_cast<std::uint32_t>(fault.cell)};
  network.tell([&](Observer& observer) { observer.frame_planted(network, to, frame, fault); });
  input.kind = RS_INPUT_FRAME;
  input.port = to.port;
  input.frame = frame;
  step_cell(input);
}

void Network::RunningFault::trouble_ethernet(bool begins) {
  std::vector<Fault>& in_force = network.ethernet_faults_;
  if (begins) {
    in_force.push_back(fault);
  } else if (const auto at = std::ranges::find(in_force, fault); at != in_force.end()) {
    in_force.erase(at);
  }
}

}  // namespace robotskin::world
