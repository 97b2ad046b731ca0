// SPDX-License-Identifier: Apache-2.0
#include "campaign/sample_ledger.hpp"

#include <algorithm>
#include <initializer_list>
#include <utility>

#include "campaign/datagram_frames.hpp"
#include "robotskin/timing.h"
#include "world/random.hpp"

namespace robotskin::campaign {
namespace {

// What the other channels say of cell and number.
std::uint32_t proof_of(std::size_t cell, std::uint16_t number) {
  return static_cast<std::uint32_t>(world::scramble(cell << 16 | number));
}

constexpr std::size_t cells_in_touch = 8;
constexpr std::int64_t touch_ns = 32 * ms;
constexpr std::int32_t touch_counts = 100;  // more than any threshold
// Under overload a tree may lose what its cells send beyond what its cable carries. Each cell too many brings its
// control and its reports along as well, for which this chosen share is allowed. And a tree loses what was on its way
// when the overload began: the queue of the cell at the cable, and of the one below.
constexpr double overloaded_share = 0.3, overloaded_more = 2 * RS_QUEUE_DATA;

}  // namespace

SampleLedger::SampleLedger(const FaultCase& drawn, BreakLog& breaks)
    : breaks_(breaks),
      cells_(drawn.wiring.cell_count()),
      workload_(drawn.workload),
      seed_(drawn.seed),
      whole_lines_(drawn.whole_lines),
      losses_(drawn.options.line) {
  if (!workload_.events || !drawn.whole_lines || drawn.while_forming || drawn.faults.size() != 1) return;
  const world::Fault& fault = drawn.faults.front();
  const world::FaultType& type = world::type_of(fault);
  const bool of_cell = type.truth.loses == world::FaultTruth::Loses::cell;
  const bool of_one_wire = type.truth.loses == world::FaultTruth::Loses::wire && (type.either || fault.cell >= 0);
  failure_.possible = of_cell || of_one_wire;
  if (of_cell) failure_.victim = fault.cell;
}

void SampleLedger::struck(const world::Network& network, GroundTruth& ground, const RecoveryChecker& recovery,
                          const CableLoads& loads) {
  crowded_out_ = 0;
  if (!failure_.possible || failure_.time_ns != 0) return;
  failure_.time_ns = network.time_ns();
  failure_.judged = recovery.whole_since_ns() < failure_.time_ns - 20 * ms;
  const std::vector<std::int32_t>& reach = ground.reach(failure_.time_ns, 0);
  failure_.spared.assign(cells_.size(), 0);
  for (std::size_t cell = 0; cell < cells_.size(); ++cell)
    failure_.spared[cell] =
        reach[cell] >= 0 && static_cast<std::int32_t>(cell) != failure_.victim && loads.within(cell, failure_.time_ns);
  // Where all copies go over one line after the repair, that line has time for them beside what goes on coming.
  constexpr std::int64_t line_share = 4;
  failure_.judged =
      failure_.judged && line_share * kept_copies(failure_.time_ns) * RS_FRAME_US * us < RS_ARQ_KEEP_US * us;
}

void SampleLedger::count_taken(std::int64_t now_ns) {
  TakenIn& here = taken_in_[static_cast<std::size_t>(now_ns / ms) % taken_in_.size()];
  if (here.ms != now_ns / ms) here = {.ms = now_ns / ms};
  ++here.samples;
}

// All that cells have taken and may still keep.
std::int64_t SampleLedger::kept_copies(std::int64_t now_ns) const {
  std::int64_t copies = 0;
  for (const TakenIn& one : taken_in_)
    if (now_ns / ms - one.ms <= RS_ARQ_KEEP_US * us / ms) copies += one.samples;
  return copies;
}

// Copies are kept for 12 ms after the sample. That is enough if the repair, whose bound is known, leaves 2 ms for the
// way.
bool SampleLedger::must_be_kept(const GroundTruth& ground, std::size_t cell, const Entry& entry, bool may_lose) const {
  constexpr std::int64_t repair_max_ns = RS_ARQ_KEEP_US * us - 2 * ms;
  const std::int64_t since_ns = entry.time_ns - failure_.time_ns;
  return failure_.judged && !may_lose && failure_.spared[cell] != 0 && since_ns > -20 * ms && since_ns < 60 * ms &&
         ground.booted_ns(cell) < entry.time_ns - delivery_ns &&
         ground.repaired_ns() - failure_.time_ns < repair_max_ns;
}

// Touches come and go, each on a few cells beside each other.
bool SampleLedger::touched(std::size_t cell, std::int64_t time_ns) const {
  const std::uint64_t touch = (cell / cells_in_touch) << 32 | static_cast<std::uint64_t>(time_ns / touch_ns);
  return world::scramble(seed_ ^ touch) % 100 < static_cast<std::uint64_t>(workload_.touched_percent);
}

bool SampleLedger::sample(std::size_t index, std::int64_t time_ns, rs_sample& sample) {
  Cell& cell = cells_[index];
  const std::uint16_t number = cell.next++;
  cell.entry[number % kept] = {.time_ns = time_ns, .number = number};
  const std::uint32_t proof = proof_of(index, number);
  sample = {};
  sample.value[RS_CHANNEL_proximity] = number;
  sample.value[RS_CHANNEL_force_1] = static_cast<std::int32_t>(index & 0x3FF);
  sample.value[RS_CHANNEL_force_2] = static_cast<std::int32_t>(proof & 0x3FF);
  sample.value[RS_CHANNEL_force_3] = static_cast<std::int32_t>(proof >> 10 & 0x3FF);
  sample.value[RS_CHANNEL_acceleration_x] = static_cast<std::int32_t>(proof >> 20 & 0x1FF);
  if (workload_.events && touched(index, time_ns))
    sample.value[RS_CHANNEL_acceleration_z] = number % 2 == 0 ? touch_counts : -touch_counts;
  return false;
}

bool SampleLedger::cell_stepped(const world::Network& network, std::size_t index, const rs_input& input) {
  const rs_cell& state = network.cell(index);
  Cell& cell = cells_[index];
  if (state.id != cell.id) {
    cell.id = state.id;
    cell.named_ns = network.time_ns();
  }
  const bool sent = input.kind == RS_INPUT_SAMPLE && state.sampling.sequence != cell.sequence;
  if (sent) {
    cell.entry[static_cast<std::uint16_t>(cell.next - 1) % kept].sent = true;
    ++taken_;
    count_taken(network.time_ns());
  }
  cell.sequence = state.sampling.sequence;
  return sent;
}

TakenSample SampleLedger::taken_in(const std::uint8_t* frame_at) {
  rs_clock frame;
  rs_clock_unpack(&frame, frame_at);
  return {frame.force_1, static_cast<std::uint16_t>(frame.proximity)};
}

TakenSample SampleLedger::taken_in(const rs_sample& own) {
  return {static_cast<std::uint32_t>(own.value[RS_CHANNEL_force_1]),
          static_cast<std::uint16_t>(own.value[RS_CHANNEL_proximity])};
}

std::optional<std::int64_t> SampleLedger::taken_ns(const std::uint8_t* frame) const {
  const rs_frame_type type = rs_frame_type_of(frame);
  if (type != RS_TYPE_clock && type != RS_TYPE_event) return std::nullopt;
  const TakenSample sample = taken_in(frame);
  if (sample.number == 0 || sample.cell >= cells_.size()) return std::nullopt;
  const Entry& entry = cells_[sample.cell].entry[sample.number % kept];
  if (entry.number != sample.number) return std::nullopt;
  return entry.time_ns;
}

void SampleLedger::crowded_out(TakenSample sample) {
  if (sample.cell >= cells_.size()) return;
  Entry& entry = cells_[sample.cell].entry[sample.number % kept];
  if (entry.number == sample.number) entry.crowded_out = true;
}

void SampleLedger::datagram(const world::Network& network, const GroundTruth& ground, const RouteChecker& routes,
                            std::span<const std::uint8_t> datagram) {
  for_each_frame(datagram, [&](const std::uint8_t* frame_at) {
    const rs_frame_type type = rs_frame_type_of(frame_at);
    if (type != RS_TYPE_clock && type != RS_TYPE_event) return;
    rs_clock frame;
    rs_clock_unpack(&frame, frame_at);
    if (frame.source != RS_ID_NONE) record(network, ground, routes, frame);  // 0: stuffed in by a fault
  });
}

// However long the damage lasts, it may spoil only so many samples. On their way they may have passed the damaged cell
// whichever cell has taken them.
void SampleLedger::excuse(const world::Network& network, const GroundTruth& ground, std::size_t cell) {
  const auto faults = static_cast<std::uint64_t>(std::max(ground.memory_faults(), 1));
  if (++excused_ == faults * excused_max + 1)
    breaks_.add(Invariant::true_sample, network.time_ns(), {std::min(cell, cells_.size() - 1)},
                {{"false samples", static_cast<std::int64_t>(excused_)}, {"memory faults", ground.memory_faults()}});
}

void SampleLedger::record(const world::Network& network, const GroundTruth& ground, const RouteChecker& routes,
                          const rs_clock& frame) {
  const std::int64_t now_ns = network.time_ns();
  const std::size_t index = frame.force_1;
  const auto number = static_cast<std::uint16_t>(frame.proximity);
  const std::uint32_t proof = proof_of(index, number);
  const bool lawless = ground.lawless(now_ns - delivery_ns);
  const bool proven = index < cells_.size() && frame.force_2 == (proof & 0x3FF) &&
                      frame.force_3 == (proof >> 10 & 0x3FF) &&
                      frame.acceleration_x == static_cast<std::int32_t>(proof >> 20 & 0x1FF);
  const bool known =
      proven && cells_[index].entry[number % kept].number == number && cells_[index].entry[number % kept].sent;
  if (!known) {
    if (lawless)
      excuse(network, ground, index);
    else
      breaks_.add(Invariant::true_sample, now_ns, {index},
                  {{"source", frame.source}, {"number", number}, {"proven", proven}});
    return;
  }
  Cell& cell = cells_[index];
  Entry& entry = cell.entry[number % kept];
  bool excused = false;  // once a sample
  const auto must_not_be = [&](Invariant invariant, std::initializer_list<Value> values) {
    if (!lawless) return breaks_.add(invariant, now_ns, {index}, values);
    if (!std::exchange(excused, true)) excuse(network, ground, index);
  };
  if (frame.source != cell.id && now_ns - cell.named_ns > 2 * delivery_ns)
    must_not_be(Invariant::true_sample, {{"source", frame.source}, {"its id", cell.id}});
  ++delivered_;
  // What has come by another way as well is marked, and told by source and sequence; then the host drops it. The
  // marked one may have been the faster.
  const bool again = entry.delivered != 0;
  const bool known_again = again && (frame.retransmitted != 0 || entry.retransmitted) &&
                           entry.sequence == static_cast<std::uint8_t>(frame.sequence) && frame.source == entry.source;
  if (again && known_again) ++repeated_;
  entry.sequence = static_cast<std::uint8_t>(frame.sequence);
  entry.source = static_cast<std::uint16_t>(frame.source);
  entry.retransmitted = entry.retransmitted || frame.retransmitted != 0;
  if (again && !known_again)
    must_not_be(Invariant::exactly_once, {{"number", number},
                                          {"us since taken", (now_ns - entry.time_ns) / us},
                                          {"times", entry.delivered + 1},
                                          {"retransmitted", frame.retransmitted}});
  if (entry.delivered < 255) ++entry.delivered;
  const auto ahead = static_cast<std::int16_t>(number - cell.last_delivered);
  if (frame.retransmitted != 0) {
    // Sent again, and so after what was not lost.
  } else if (ahead > 0 || cell.last_delivered == 0) {
    cell.last_delivered = number;
  } else if (ground.repaired_elsewhere_ns() < entry.time_ns && routes.changed_ns() < entry.time_ns - delivery_ns) {
    must_not_be(Invariant::in_order, {{"number", number}, {"after", cell.last_delivered}});
  }
}

bool SampleLedger::must_arrive(const GroundTruth& ground, const RecoveryChecker& recovery, std::size_t cell,
                               const Entry& entry) const {
  const std::int64_t rest_ns = entry.time_ns - 5 * ms;
  return !ground.samples_disturbed_since(rest_ns - ground.catch_up_ns(rest_ns)) &&
         recovery.whole_since_ns() <= entry.time_ns && ground.booted_ns(cell) <= entry.time_ns &&
         recovery.path_since_ns(cell) <= entry.time_ns;
}

void SampleLedger::poll(const world::Network& network, const GroundTruth& ground, const RecoveryChecker& recovery,
                        const CableLoads& loads) {
  const std::int64_t now_ns = network.time_ns();
  const bool whole =
      recovery.whole_since_ns() <= now_ns - 5 * ms && ground.calm(now_ns) && ground.repaired_ns() <= now_ns;
  for (std::size_t index = 0; index < cells_.size(); ++index) {
    Cell& cell = cells_[index];
    const bool within_load = loads.within(index, now_ns);
    const bool may_lose = !whole_lines_ || !within_load;
    for (; cell.checked != cell.next; ++cell.checked) {
      const Entry& entry = cell.entry[cell.checked % kept];
      if (entry.number != cell.checked) continue;  // overwritten
      if (entry.time_ns > now_ns - delivery_ns) break;
      if (!entry.sent) continue;
      const bool due = whole && must_arrive(ground, recovery, index, entry);
      if (due && !within_load) {
        ++sent_overloaded_;
        lost_overloaded_ += entry.delivered == 0;
      }
      if (entry.crowded_out) {
        if (due && within_load && entry.delivered == 0) count_crowded_out(now_ns, index);
        continue;
      }
      const bool arrives = due && within_load;
      if (arrives) losses_.due(network.cell(index).route.hops);
      if (entry.delivered != 0) continue;
      if (must_be_kept(ground, index, entry, may_lose))
        breaks_.add(Invariant::event_kept, now_ns, {index},
                    {{"number", entry.number}, {"us after the failure", (entry.time_ns - failure_.time_ns) / us}});
      if (!arrives) continue;
      if (!whole_lines_) {
        losses_.add(1);
        continue;
      }
      breaks_.add(Invariant::none_lost, now_ns, {index},
                  {{"number", entry.number},
                   {"us ago", (now_ns - entry.time_ns) / us},
                   {"dropped in all", static_cast<std::int64_t>(network.frames_dropped())},
                   {"overrun in all", static_cast<std::int64_t>(network.counts().frames_overrun)}});
    }
  }
}

// Of those that are due, within load, and lost.
void SampleLedger::count_crowded_out(std::int64_t now_ns, std::size_t cell) {
  crowded_out_most_ = std::max(crowded_out_most_, ++crowded_out_);
  if (crowded_out_ == crowded_out_max + 1)
    breaks_.add(Invariant::none_lost, now_ns, {cell},
                {{"crowded out since the last fault", static_cast<std::int64_t>(crowded_out_)}});
}

void SampleLedger::finish(const world::Network& network, const CableLoads& loads) {
  const double overloaded_at_most =
      static_cast<double>(loads.excess()) + overloaded_share * static_cast<double>(sent_overloaded_) + overloaded_more;
  if (static_cast<double>(lost_overloaded_) > overloaded_at_most)
    breaks_.add(Invariant::overload, network.time_ns(), {},
                {{"lost under overload", static_cast<std::int64_t>(lost_overloaded_)},
                 {"of", static_cast<std::int64_t>(sent_overloaded_)},
                 {"at most", static_cast<std::int64_t>(overloaded_at_most)}});

  if (losses_.too_many())
    breaks_.add(Invariant::none_lost, network.time_ns(), {},
                {{"lost on lossy lines", losses_.lost()}, {"at most", losses_.at_most()}});
}

}  // namespace robotskin::campaign
