#include "campaign/queue_watch.hpp"

#include <algorithm>

namespace robotskin::campaign {

void QueueWatch::cell_stepped(const world::Network& network, const Ground& ground, const RecoveryWatch& recovery,
                              std::size_t index, bool within_load) {
  const rs_cell& state = network.cell(index);
  const rs_ring& ring = state.queues.data;
  Cell& cell = cells_[index];
  if (ring.first == cell.first && ring.count == cell.count) return;
  const std::int64_t now_ns = network.time_ns();
  const bool lawless = ground.lawless(now_ns);
  if (ring.count > RS_QUEUE_DATA || state.queues.slow.count > RS_QUEUE_SLOW ||
      state.queues.down.count > RS_QUEUE_DOWN) {
    if (!lawless)
      breaks_.add(Invariant::queue_bound, now_ns, {index},
                  {{"data", ring.count}, {"slow", state.queues.slow.count}, {"down", state.queues.down.count}});
    return;
  }
  const unsigned left = (ring.first - cell.first) & (RS_QUEUE_DATA - 1U);
  const unsigned came = (ring.count + left - cell.count) & (2U * RS_QUEUE_DATA - 1U);
  const bool judged = within_load && !lawless && ground.calm(now_ns) && state.counts.frames_dropped == cell.dropped;
  for (unsigned i = 0; i < std::min<unsigned>(left, cell.count); ++i) {
    const std::int64_t since_ns = cell.since_ns[(cell.first + i) & (RS_QUEUE_DATA - 1U)];
    if (!judged || recovery.whole_since_ns() > since_ns || ground.samples_disturbed(since_ns - 10 * ms)) continue;
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
}

}  // namespace robotskin::campaign
