// SPDX-License-Identifier: Apache-2.0
#include "campaign/sampling_checker.hpp"

#include <algorithm>
#include <cstdlib>

#include "robotskin/timing.h"

namespace robotskin::campaign {
namespace {

// From the first way on, or the end of an overload: requests come every 10 ms, and crowd each other out while all ask.
constexpr std::int64_t naming_ns = 200 * ms;

rs_settings settings_in(const Workload& workload) {
  rs_settings settings;
  rs_settings_default(&settings);
  return settings_of(workload).value_or(settings);
}

}  // namespace

SamplingChecker::SamplingChecker(const FaultCase& drawn, BreakLog& breaks)
    : breaks_(breaks),
      cells_(drawn.wiring.cell_count()),
      events_(drawn.workload.events),
      takes_time_(drawn.options.processor != world::Processor::none) {
  const rs_settings settings = settings_in(drawn.workload);
  const std::uint32_t rate_hz = events_ ? settings.event_rate_hz : settings.clock_rate_hz;
  period_ns_ = 1000 * ms / rate_hz;
  threshold_ = settings.threshold[RS_CHANNEL_acceleration_z];
}

// Longest silence that its mode and divisor allow, a quarter of a period for the change of its phase, and what inputs
// before it take. The time by which it samples is less sure by the frames that a tick on its way may wait for.
std::int64_t SamplingChecker::silence_ns(const Cell& cell, std::int32_t hops) const {
  constexpr std::int64_t tick_waits_ns = 2 * RS_FRAME_US * us;
  const std::int64_t waits_ns = takes_time_ ? ms + hops * tick_waits_ns : 0;
  if (events_) return (RS_REFRESH_US + RS_REFRESH_JITTER_US) * us + period_ns_ + waits_ns;
  return cell.largest * (1 + cell.changes) * period_ns_ + period_ns_ / 4 + waits_ns;
}

void SamplingChecker::note(Cell& cell, const rs_wave& wave) {
  const auto divisor = std::max<std::uint8_t>(wave.rate_divisor, 1);
  if (divisor != cell.divisor || wave.root != cell.root || wave.sequence < cell.tick) {
    ++cell.changes;
    cell.changed = true;
  }
  cell.largest = std::max(cell.largest, divisor);
  cell.divisor = divisor;
  cell.root = wave.root;
  cell.tick = wave.sequence;
}

void SamplingChecker::cell_stepped(const world::Network& network, const GroundTruth& ground, std::size_t index,
                                   const rs_input& input) {
  const rs_cell& state = network.cell(index);
  Cell& cell = cells_[index];
  if (state.id == RS_ID_NONE)
    cell.named_ns = -1;
  else if (cell.named_ns < 0)
    cell.named_ns = network.time_ns();
  if (input.kind == RS_INPUT_SAMPLE) {
    const std::int64_t now_ns = network.time_ns();
    note(cell, state.route.wave);
    const std::int32_t value = input.sample->value[RS_CHANNEL_acceleration_z];
    const bool refused = state.counts.frames_dropped != cell.dropped;  // it found no room for it
    if (refused) cell.sent_ns = now_ns;
    if (state.sampling.sequence != cell.sequence) {
      cell.sent_ns = now_ns;
      cell.sent_value = value;
      cell.changes = cell.changed ? 1 : 0;
      if (!cell.changed) cell.largest = cell.divisor;
      cell.changed = false;
    } else if (events_ && std::abs(value - cell.sent_value) >= threshold_ && cell.sent_ns > ground.booted_ns(index) &&
               cell.sent_ns > ground.lawless_until_ns(index) && !ground.lawless(now_ns, index) && !refused) {
      breaks_.add(Invariant::sampled, now_ns, {index}, {{"value", value}, {"sent last", cell.sent_value}});
    }
  }
  cell.sequence = state.sampling.sequence;
  cell.dropped = state.counts.frames_dropped;
}

void SamplingChecker::poll(const world::Network& network, const GroundTruth& ground, const RecoveryChecker& recovery,
                           const CableLoads& loads, const Overruns& overruns) {
  const std::int64_t now_ns = network.time_ns();
  for (std::size_t index = 0; index < cells_.size(); ++index) {
    Cell& cell = cells_[index];
    if (!recovery.calm(index, now_ns) || !ground.runs(index) || ground.is_zombie(index) || !recovery.has_path(index))
      continue;
    const std::int64_t able_ns =
        std::max({recovery.repaired_ns(index), recovery.path_since_ns(index), ground.booted_ns(index),
                  overruns.overtaxed_ns(network.cell(index).route.wave.root)});
    note(cell, network.cell(index).route.wave);
    if (cell.named_ns < 0) {
      if (now_ns - std::max(able_ns, loads.overloaded_ns(index)) <= naming_ns || cell.told) continue;
      breaks_.add(Invariant::sampled, now_ns, {index}, {{"us without an id", (now_ns - able_ns) / us}});
      cell.told = true;
      continue;
    }
    const std::int64_t silent_ns = now_ns - std::max({able_ns, cell.named_ns, cell.sent_ns});
    const bool silent = silent_ns > silence_ns(cell, network.cell(index).route.hops);
    if (silent && !cell.told)
      breaks_.add(Invariant::sampled, now_ns, {index},
                  {{"us of silence", silent_ns / us},
                   {"divisor", cell.divisor},
                   {"sampling", network.cell(index).sampling.running}});
    cell.told = silent;
  }
}

}  // namespace robotskin::campaign
