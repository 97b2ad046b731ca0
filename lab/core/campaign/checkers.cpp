// SPDX-License-Identifier: Apache-2.0
#include "campaign/checkers.hpp"

#include <array>
#include <utility>

#include "robotskin/crc.h"

namespace robotskin::campaign {

using world::Network;

namespace {

constexpr std::int64_t settled_ns = 20 * ms;

}  // namespace

void Checkers::watch(Network& network, const std::vector<world::Fault>& faults) {
  network_ = &network;
  ground_.emplace(network, times_, frame_loss(line_));
  ground_->expect(faults);
  beacons_.emplace(*ground_);
  routes_.emplace(network, *ground_, *beacons_, breaks_);
  recovery_.emplace(network, *ground_, *routes_, breaks_, whole_lines_);
  control_.emplace(network.cell_count(), ground_->wire_count(), line_, times_, breaks_);
  network.observe(*this);
}

void Checkers::cell_stepped(const Network& network, std::size_t cell, const rs_input& input, const rs_output&) {
  if (input.kind == RS_INPUT_BOOT) ground_->booted(cell);
  // Flips of one bit may cancel each other; what is whole by its checksum is taken. What was forged is no word of the
  // neighbour's.
  const bool forged = input.kind == RS_INPUT_FRAME && std::exchange(forged_comes_, false);
  if (input.kind == RS_INPUT_FRAME && !forged && rs_frame_intact(input.frame))
    routes_->frame_taken(ground_->wire_of_cell(cell, input.port), input.frame,
                         network.time_ns() - std::int64_t{input.late_us} * us);
  const bool out_of_hops = input.kind == RS_INPUT_FRAME && !rs_sample_has_hop(input.frame);
  routes_->cell_stepped(cell, input, out_of_hops ? ledger_.taken_ns(input.frame) : std::nullopt);
  if (ledger_.cell_stepped(network, cell, input)) loads_.sent(network.cell(cell).route.wave.root);
  sampling_.cell_stepped(network, *ground_, cell, input);
  touch_.cell_stepped(network, *ground_, cell, input);
  if (input.kind == RS_INPUT_FRAME) forgeries_.cell_stepped(network, cell);
  const bool within_load = loads_.within(cell, network.time_ns());
  topology_.cell_stepped(network, cell, input, within_load);
  if (const auto lost = queues_.cell_stepped(network, *ground_, *recovery_, cell, input, within_load))
    ledger_.crowded_out(*lost);
}

void Checkers::frame_sent(const Network& network, world::WireEnd from, const std::uint8_t* frame) {
  control_->frame_sent(*ground_, ground_->wire_of(from), frame, network.time_ns());
  if (from.at != world::WireEnd::At::unit) {
    if (rs_frame_type_of(frame) != RS_TYPE_torque) return;
    const std::int32_t far = ground_->far(ground_->wire_of(from));
    const bool to_unit = far != GroundTruth::no_wire && !ground_->is_cell(static_cast<std::size_t>(far));
    if (to_unit) queues_.sum_sent(network.cell(from.index).route.wave.root);
    return;
  }
  tags_.frame_sent(network, from.index, frame);
  if (rs_frame_type_of(frame) == RS_TYPE_grant) {
    balance_.granted(network, *routes_, frame);
    rs_grant grant;
    rs_grant_unpack(&grant, frame);
    if (grant.cell != RS_ID_NONE) ground_->granted();
  }
  if (rs_frame_type_of(frame) != RS_TYPE_tick) return;
  rs_tick tick;
  rs_tick_unpack(&tick, frame);
  beacons_->issued(tick);
}

void Checkers::frame_ended(const Network& network, world::WireEnd, world::WireEnd to, const std::uint8_t* frame,
                           world::FrameFate fate) {
  if (!whole_lines_ && fate != world::FrameFate::overrun)
    ground_->frame_ended(ground_->wire_of(to), fate == world::FrameFate::delivered);
  if (fate != world::FrameFate::overrun || !overruns_.lost(network, *ground_, to.index)) return;
  topology_.crowded_out(network.time_ns(), frame);
  const rs_frame_type type = rs_frame_type_of(frame);
  if (type == RS_TYPE_clock || type == RS_TYPE_event) ledger_.crowded_out(SampleLedger::taken_in(frame));
}

void Checkers::frame_planted(const Network& network, world::WireEnd to, const std::uint8_t* frame,
                             const world::Fault& fault) {
  const bool forged = world::type_of(fault).truth.plants == world::FaultTruth::Plants::forged;
  ground_->planted(ground_->wire_of(to));
  if (forged) ground_->forged(ground_->wire_of(to));
  forged_comes_ = forged;
  forgeries_.frame_planted(network, *ground_, *routes_, to.index, to.port, frame, forged);
  if (forged) return;
  routes_->frame_planted(ground_->wire_of(to), frame);
  if (forgeries_.may_take_time()) ground_->misled();
  if (forgeries_.bears_no_tag()) ground_->untold();
}

void Checkers::datagram_to_host(const Network& network, std::size_t, std::span<const std::uint8_t> bytes) {
  ledger_.datagram(network, *ground_, *routes_, bytes);
  torques_.datagram(network, *ground_, bytes);
  touch_.datagram(network, bytes);
  topology_.datagram(network, bytes);
}

void Checkers::fault_applied(const Network&, const world::Fault& fault, int phase) {
  ground_->fault(fault, phase);
  ground_->settle();
  routes_->settle();
  ledger_.struck(*network_, *ground_, *recovery_, loads_);
  recovery_->struck(world::type_of(fault).truth.everywhere, loads_.any_overloaded(network_->time_ns()));
}

void Checkers::weigh() {
  std::array<std::uint32_t, CableLoads::roots> late_sums{};
  queues_.end_epoch();
  for (std::size_t root = 0; root < late_sums.size(); ++root) late_sums[root] = queues_.late_sums(root, port_load_);
  loads_.weigh(*network_, *ground_, late_sums);
  overruns_.weigh(network_->time_ns(), loads_, late_sums);
  const std::int64_t now_ns = network_->time_ns();
  const bool undisturbed = ground_->calm(now_ns) && now_ns > ground_->repaired_ns() + settled_ns &&
                           recovery_->whole_since_ns() < now_ns - settled_ns;
  balance_.weigh(now_ns, loads_.cells(), undisturbed);
  balance_.weigh_chances(*network_, *ground_, *routes_, *recovery_, undisturbed);
  if (whole_lines_)
    queues_.count_drops(*network_, *ground_, *routes_, *recovery_, overruns_, loads_, late_sums, port_load_,
                        undisturbed);
}

void Checkers::poll() {
  recovery_->poll();
  sampling_.poll(*network_, *ground_, *recovery_, loads_, overruns_);
  orders_.poll(*network_, *ground_, *routes_, *recovery_);
  torques_.poll(*network_, *ground_, *routes_, *recovery_, loads_);
  if (network_->time_ns() / ms % 4 == 0) {
    weigh();
    tags_.poll(*network_, *ground_);
    ledger_.poll(*network_, *ground_, *recovery_, loads_);
  }
  touch_.poll(*network_, *ground_);
  control_->poll(*network_, *ground_, overruns_);
}

void Checkers::finish() {
  recovery_->finish();
  balance_.finish(network_->time_ns());
  ledger_.finish(*network_, loads_);
  torques_.finish(network_->time_ns());
  orders_.finish(*network_);
  topology_.finish(*network_, *ground_, *recovery_, overruns_);
}

}  // namespace robotskin::campaign
