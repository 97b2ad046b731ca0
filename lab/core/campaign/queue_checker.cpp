// SPDX-License-Identifier: Apache-2.0
#include "campaign/queue_checker.hpp"

#include <algorithm>

#include "robotskin/crc.h"

namespace robotskin::campaign {
namespace {

constexpr std::int64_t two_ticks_ns = 2 * ms;
// Every queue of a path may be full when the divisor comes, and empties into the next as fast as the line goes.
constexpr std::int64_t drained_hop_ns = RS_QUEUE_DATA * RS_FRAME_US * us;

// Whether trees formed in that time: until so long after every cell has a way, sums of single cells may go up alone.
bool formed_since(const RecoveryChecker& recovery, std::int64_t begun_ns) {
  constexpr std::int64_t sums_ns = 2 * RS_EPOCH_TICKS * ms;
  return recovery.whole_since_ns() > begun_ns - sums_ns;
}

std::uint8_t queue_most(const rs_cell& state) {
  return std::min<std::uint8_t>(state.queues.data_most, RS_QUEUE_DATA);
}

}  // namespace

std::optional<TakenSample> QueueChecker::cell_stepped(const world::Network& network, const GroundTruth& ground,
                                                      const RecoveryChecker& recovery, std::size_t index,
                                                      const rs_input& input, bool within_load) {
  const rs_cell& state = network.cell(index);
  const rs_ring& ring = state.queues.data;
  Cell& cell = cells_[index];
  const bool dropped = state.counts.frames_dropped != cell.dropped;
  const std::int64_t now_ns = network.time_ns();
  const bool may_fill = cell.crowded || formed_since(recovery, cell.begun_ns) || ground.moving(now_ns);
  // Either the oldest sample has gone, or the one that came: a cell whose subtree has grown leaves some out sooner.
  const std::uint8_t most = std::exchange(cell.most, queue_most(state));
  const bool was_full = may_fill && cell.count >= most;
  const bool own = input.kind == RS_INPUT_SAMPLE;
  const bool came_up = input.kind == RS_INPUT_FRAME && rs_frame_type_of(input.frame) == RS_TYPE_clock;
  const bool left_out = was_full && dropped && (own || came_up);
  const auto that_came = [&] {
    return own ? SampleLedger::taken_in(*input.sample) : SampleLedger::taken_in(input.frame);
  };
  if (ring.first == cell.first && ring.count == cell.count) {
    cell.dropped = state.counts.frames_dropped;
    if (!left_out) return std::nullopt;
    ++cell.crowded_out;
    return that_came();
  }
  const bool lawless = ground.lawless(now_ns, index);
  if (ring.count > RS_QUEUE_DATA || state.queues.slow.count > RS_QUEUE_SLOW ||
      state.queues.down.count > RS_QUEUE_DOWN) {
    if (!lawless)
      breaks_.add(Invariant::queue_bound, now_ns, {index},
                  {{"data", ring.count}, {"slow", state.queues.slow.count}, {"down", state.queues.down.count}});
    return std::nullopt;
  }
  const unsigned left = (ring.first - cell.first) & (RS_QUEUE_DATA - 1U);
  const unsigned came = (ring.count + left - cell.count) & (2U * RS_QUEUE_DATA - 1U);
  if (cell.count == 0) cell.begun_ns = now_ns;
  cell.crowded = cell.crowded || state.queues.data_again > 0 || formed_since(recovery, cell.begun_ns);
  for (unsigned i = 0; i < std::min<unsigned>(came, ring.count) && !cell.crowded; ++i)
    cell.crowded =
        rs_frame_is_retransmitted(state.queues.data_frame[(ring.first + ring.count - 1U - i) & (RS_QUEUE_DATA - 1U)]);
  std::optional<TakenSample> lost;
  const bool came_not = came == 0 && left_out;
  if (was_full && dropped && left > 0 && (came_not || cell.count == RS_QUEUE_DATA)) {
    lost = came_not ? that_came() : cell.oldest;
    ++cell.crowded_out;
  }
  const bool judged = within_load && !lawless && ground.calm(now_ns) && !dropped && !cell.crowded;
  for (unsigned i = 0; i < std::min<unsigned>(left, cell.count); ++i) {
    const std::int64_t since_ns = cell.since_ns[(cell.first + i) & (RS_QUEUE_DATA - 1U)];
    if (!judged || recovery.whole_since_ns() > since_ns || ground.samples_disturbed_since(since_ns - 10 * ms)) continue;
    longest_ns_ = std::max(longest_ns_, now_ns - since_ns);
    if (now_ns - since_ns < waiting_max_ns) continue;
    breaks_.add(Invariant::waiting, now_ns, {index},
                {{"us", (now_ns - since_ns) / us}, {"samples waiting", cell.count}});
  }
  for (unsigned i = 0; i < std::min<unsigned>(came, ring.count); ++i)
    cell.since_ns[(ring.first + ring.count - 1U - i) & (RS_QUEUE_DATA - 1U)] = now_ns;
  cell.first = ring.first;
  cell.count = ring.count;
  cell.dropped = state.counts.frames_dropped;
  if (ring.count == RS_QUEUE_DATA)
    cell.oldest = SampleLedger::taken_in(state.queues.data_frame[ring.first & (RS_QUEUE_DATA - 1U)]);
  cell.crowded = cell.crowded && ring.count > 0;
  return lost;
}

void QueueChecker::count_drops(const world::Network& network, const GroundTruth& ground, const RouteChecker& routes,
                               const RecoveryChecker& recovery, const Overruns& overruns, const CableLoads& loads,
                               std::span<const std::uint32_t> late_sums, PortLoad port, bool undisturbed) {
  const std::int64_t now_ns = network.time_ns();
  const std::span<const std::uint32_t> load = loads.cells();
  std::int32_t deepest = 0;
  for (std::size_t index = 0; index < cells_.size(); ++index)
    if (ground.runs(index) && network.cell(index).route.parent_port != RS_NO_PARENT)
      deepest = std::max<std::int32_t>(deepest, network.cell(index).route.hops);
  const std::int64_t known_ns = routes.changed_ns() + two_ticks_ns + deepest * port.known_hop_ns;
  const bool drained = known_ns + deepest * drained_hop_ns < counted_ns_;
  const bool judged =
      !events_ && undisturbed && known_ns < counted_ns_ && !ground.samples_disturbed_since(counted_ns_ - 20 * ms);
  for (std::size_t index = 0; index < cells_.size(); ++index) {
    const std::uint32_t dropped = network.cell(index).counts.frames_dropped - cells_[index].crowded_out;
    const rs_wave& wave = network.cell(index).route.wave;
    const std::uint32_t divisor = std::max<std::uint32_t>(wave.rate_divisor, 1);
    const bool too_low = load[wave.root] > divisor * port.bearable;
    const std::uint32_t with_sums = load[wave.root] + divisor * late_sums[wave.root];
    const bool fills =
        late_sums[wave.root] > 0 && with_sums > divisor * port.draining && with_sums <= divisor * port.bearable;
    if (divisor > cells_[index].divisor || fills) cells_[index].eased_ns = now_ns;
    cells_[index].divisor = divisor;
    const bool eased = cells_[index].eased_ns + deepest * drained_hop_ns < counted_ns_;
    const bool empty = drained && eased && load[wave.root] <= divisor * port.draining;
    const bool overtaxed = counted_ns_ - overruns.overtaxed_ns(wave.root) < CableLoads::drained_ns;
    if (judged && !overtaxed && (too_low || empty) && recovery.has_path(index) &&
        dropped != cells_[index].dropped_in_all)
      breaks_.add(Invariant::overload, now_ns, {index},
                  {{"dropped", static_cast<std::int64_t>(dropped) - cells_[index].dropped_in_all},
                   {"divisor", wave.rate_divisor},
                   {"cells", load[wave.root]},
                   {"us since a change of parent", (now_ns - routes.changed_ns()) / us}});
    cells_[index].dropped_in_all = dropped;
  }
  counted_ns_ = now_ns;
}

}  // namespace robotskin::campaign
