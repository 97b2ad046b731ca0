// SPDX-License-Identifier: Apache-2.0
#include "campaign/run_case.hpp"

#include <algorithm>

#include "campaign/checkers.hpp"

namespace robotskin::campaign {

CaseReport run_case(const FaultCase& drawn) {
  world::NetworkOptions options = drawn.options;
  options.faults = drawn.faults;
  const std::size_t cells = drawn.wiring.cell_count();
  Checkers checkers(drawn);
  world::Network network(drawn.wiring, options, checkers.ledger(), checkers);
  checkers.watch(network, drawn.faults);
  for (std::size_t cell = 0; cell < cells && drawn.workload.limbs > 0; ++cell)
    network.contribute(cell, contribution_of(cell, cells, drawn.workload.limbs));
  checkers.touch().prepare(network);
  for (std::int64_t time_ns = ms; time_ns <= drawn.duration_ns; time_ns += ms) {
    network.run_until(time_ns);
    checkers.poll();
    checkers.orders().send(network);
  }
  checkers.finish();

  CaseReport report;
  report.seed = drawn.seed;
  report.breaks = checkers.breaks().kept();
  report.break_count = checkers.breaks().count();
  report.log_hash = network.log_hash();
  report.events = network.counts().events;
  report.samples_taken = checkers.ledger().taken();
  report.samples_delivered = checkers.ledger().delivered();
  report.crowded_out_most = checkers.ledger().crowded_out_most();
  report.lost_overloaded = checkers.ledger().lost_overloaded();
  report.excused = checkers.ledger().excused();
  report.events_repeated = checkers.ledger().repeated();
  report.torque_sums = checkers.torques().sums();
  report.torque_epochs = checkers.torques().epochs_judged();
  report.frames_planted = checkers.forgeries().planted();
  report.simulated_s = 1e-9 * static_cast<double>(network.time_ns());
  report.longest_repair_ms = 1e-6 * static_cast<double>(checkers.recovery().longest_repair_ns());
  report.longest_wait_ms = 1e-6 * static_cast<double>(checkers.queues().longest_ns());
  report.largest_control_share = checkers.control().largest_share();
  return report;
}

namespace {

bool breaks(const FaultCase& drawn, Invariant invariant) {
  const CaseReport report = run_case(drawn);
  return std::ranges::any_of(report.breaks, [&](const Break& b) { return b.invariant == invariant; });
}

}  // namespace

FaultCase shrink(const FaultCase& original, Invariant invariant, int runs_max) {
  FaultCase smallest = original;
  int runs = 0;
  const auto try_it = [&](const FaultCase& candidate) {
    if (runs++ >= runs_max || !breaks(candidate, invariant)) return false;
    smallest = candidate;
    return true;
  };
  for (std::size_t i = 0; i < smallest.faults.size();) {
    std::vector<bool> keep(smallest.faults.size(), true);
    keep[i] = false;
    if (!try_it(with_faults(smallest, keep))) ++i;
  }
  // Halves of the cells, quarters, and so on, as far as the break stays.
  for (std::size_t piece = smallest.wiring.cell_count() / 2; piece >= 1; piece /= 2) {
    for (std::size_t first = 0; first < smallest.wiring.cell_count();) {
      std::vector<bool> keep(smallest.wiring.cell_count(), true);
      for (std::size_t i = first; i < std::min(first + piece, keep.size()); ++i) keep[i] = false;
      const FaultCase candidate = with_cells(smallest, keep);
      const bool same_faults = candidate.faults.size() == smallest.faults.size();
      if (!same_faults || candidate.wiring.cell_count() == 0 || !try_it(candidate)) first += piece;
    }
  }
  return smallest;
}

}  // namespace robotskin::campaign
