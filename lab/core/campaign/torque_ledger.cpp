// SPDX-License-Identifier: Apache-2.0
#include "campaign/torque_ledger.hpp"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <initializer_list>
#include <utility>

#include "campaign/datagram_frames.hpp"
#include "campaign/epoch_times.hpp"
#include "robotskin/timing.h"

namespace robotskin::campaign {
namespace {

constexpr unsigned bits_per_joint = 15;

std::size_t share_of(std::size_t cells, std::int32_t limbs) {
  return (cells + static_cast<std::size_t>(limbs) - 1) / static_cast<std::size_t>(limbs);
}

}  // namespace

rs_contribution contribution_of(std::size_t cell, std::size_t cells, std::int32_t limbs) {
  const std::size_t share = share_of(cells, limbs), bit = cell % share;
  rs_contribution contribution{};
  contribution.limb = static_cast<std::uint8_t>(cell / share);
  contribution.parts = 1;
  contribution.joint[bit / bits_per_joint] = 1 << bit % bits_per_joint;
  return contribution;
}

TorqueLedger::TorqueLedger(std::size_t cells, std::int32_t limbs, ProcessingTimes times, const world::LineQuality& line,
                           BreakLog& breaks)
    : breaks_(breaks), cells_(cells), limbs_(limbs), times_(times), losses_(line) {}

void TorqueLedger::finish(std::int64_t now_ns) {
  if (losses_.too_many())
    breaks_.add(Invariant::torque_complete, now_ns, {},
                {{"missing on lossy lines", losses_.lost()}, {"at most", losses_.at_most()}});
}

void TorqueLedger::datagram(const world::Network& network, const GroundTruth& ground,
                            std::span<const std::uint8_t> datagram) {
  if (!in_use()) return;
  for_each_frame(datagram, [&](const std::uint8_t* frame_at) {
    if (rs_frame_type_of(frame_at) != RS_TYPE_torque) return;
    rs_torque torque;
    rs_torque_unpack(&torque, frame_at);
    if (torque.cells > 0) add(network, ground, torque);
  });
}

void TorqueLedger::add(const world::Network& network, const GroundTruth& ground, const rs_torque& torque) {
  const std::int64_t now_ns = network.time_ns();
  const std::array<std::int32_t, RS_JOINTS_PER_PART> joints{torque.joint_1, torque.joint_2, torque.joint_3,
                                                            torque.joint_4, torque.joint_5, torque.joint_6};
  const std::size_t share = share_of(cells_, limbs_);
  // Once a sum.
  bool excused = false;
  const auto must_not_be = [&](Invariant invariant, std::initializer_list<std::size_t> cells,
                               std::initializer_list<Value> values) {
    if (!ground.lawless(now_ns - complete_ns)) return breaks_.add(invariant, now_ns, cells, values);
    if (!std::exchange(excused, true)) excuse(now_ns, ground);
  };
  unsigned ones = 0;
  for (const std::int32_t joint : joints) ones += static_cast<unsigned>(std::popcount(static_cast<unsigned>(joint)));
  ++sums_;
  if (ones != torque.cells || torque.saturated != 0) {
    must_not_be(Invariant::torque_count, {},
                {{"epoch", torque.epoch},
                 {"limb", torque.limb},
                 {"cells", torque.cells},
                 {"different ones", static_cast<std::int64_t>(ones)}});
    return;
  }
  Epoch& epoch = epochs_[torque.epoch];
  if (epoch.first_ns < 0 || now_ns - epoch.first_ns > forgotten_ns) {
    epoch.first_ns = now_ns;
    epoch.judged = false;
    epoch.heard.assign(cells_, 0);
  }
  for (std::size_t bit = 0; bit < cells_per_limb; ++bit) {
    if ((joints[bit / bits_per_joint] >> bit % bits_per_joint & 1) == 0) continue;
    const std::size_t cell = torque.limb * share + bit;
    if (bit >= share || cell >= cells_) {
      must_not_be(Invariant::torque_count, {},
                  {{"limb", torque.limb}, {"bit of no cell", static_cast<std::int64_t>(bit)}});
      continue;
    }
    // Where a section unit's time has leapt back, the same number comes twice.
    if (epoch.heard[cell] != 0 && now_ns > leapt_ns_ + forgotten_ns)
      must_not_be(Invariant::torque_once, {cell},
                  {{"epoch", torque.epoch}, {"us since its first sum", (now_ns - epoch.first_ns) / us}});
    epoch.heard[cell] = 1;
  }
}

void TorqueLedger::excuse(std::int64_t now_ns, const GroundTruth& ground) {
  const auto faults = static_cast<std::uint64_t>(std::max(ground.memory_faults(), 1));
  if (++excused_ == faults * excused_max + 1)
    breaks_.add(Invariant::torque_count, now_ns, {},
                {{"false sums", static_cast<std::int64_t>(excused_)}, {"memory faults", ground.memory_faults()}});
}

// Notes when a section unit's time has leapt, which its sums' numbers do as well.
void TorqueLedger::keep_time(const world::Network& network) {
  const std::int64_t now_ns = network.time_ns(), passed_ms = (now_ns - polled_ns_) / ms;
  polled_ns_ = now_ns;
  unit_time_.resize(network.unit_count());
  for (std::size_t u = 0; u < unit_time_.size(); ++u) {
    const std::uint64_t time = network.unit(u).tick_time;
    const auto ahead = static_cast<std::int64_t>(time - unit_time_[u]) - passed_ms;
    if (std::abs(ahead) > 2) leapt_ns_ = now_ns;
    if (network.unit(u).forming) forming_ns_ = now_ns;
    unit_time_[u] = time;
  }
  // Units that have not agreed yet number the same instant differently, and a cell may go from one to the other.
  for (std::size_t u = 1; u < unit_time_.size(); ++u) {
    const auto apart = static_cast<std::int64_t>(unit_time_[u] - unit_time_[0]);
    if (network.unit_runs(u) && network.unit_runs(0) && std::abs(apart) > RS_EPOCH_TICKS) leapt_ns_ = now_ns;
  }
}

void TorqueLedger::poll(const world::Network& network, const GroundTruth& ground, const RouteChecker& routes,
                        const RecoveryChecker& recovery, const CableLoads& loads) {
  if (!in_use()) return;
  keep_time(network);
  const std::int64_t now_ns = network.time_ns();
  for (Epoch& epoch : epochs_) {
    if (epoch.judged || now_ns - epoch.first_ns < complete_ns) continue;
    epoch.judged = true;
    judge(network, ground, routes, recovery, loads, epoch);
  }
}

void TorqueLedger::judge(const world::Network& network, const GroundTruth& ground, const RouteChecker& routes,
                         const RecoveryChecker& recovery, const CableLoads& loads, Epoch& epoch) {
  const std::int64_t now_ns = network.time_ns(), settled_ns = epoch.first_ns - at_rest_ns,
                     rest_ns = settled_ns - ground.catch_up_ns(settled_ns);
  if (!ground.calm(now_ns) || ground.repaired_ns() > rest_ns || recovery.whole_since_ns() > rest_ns ||
      routes.changed_ns() > rest_ns || leapt_ns_ > rest_ns || forming_ns_ > rest_ns ||
      ground.samples_disturbed_since(rest_ns))
    return;
  std::int32_t deepest = 0;
  for (std::size_t cell = 0; cell < cells_; ++cell)
    if (recovery.has_path(cell)) deepest = std::max<std::int32_t>(deepest, network.cell(cell).route.hops);
  if (!sums_in_time(deepest, limbs_, times_)) return;
  ++epochs_judged_;
  std::int64_t missing = 0;
  std::size_t one = 0;
  for (std::size_t cell = 0; cell < cells_; ++cell) {
    if (recovery.has_path(cell)) losses_.due(network.cell(cell).route.hops);
    if (epoch.heard[cell] != 0 || !recovery.has_path(cell) || ground.booted_ns(cell) > rest_ns ||
        !loads.within(cell, now_ns) || !loads.unit_within(network.cell(cell).route.wave.root, now_ns))
      continue;
    ++missing;
    one = cell;
  }
  if (!losses_.whole())
    losses_.add(missing);
  else if (missing > 0)
    breaks_.add(Invariant::torque_complete, now_ns, {one},
                {{"cells missing", missing},
                 {"us since its first sum", (now_ns - epoch.first_ns) / us},
                 {"hops", network.cell(one).route.hops}});
}

}  // namespace robotskin::campaign
