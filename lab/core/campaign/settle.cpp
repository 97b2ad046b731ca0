// SPDX-License-Identifier: Apache-2.0
#include "campaign/settle.hpp"

#include <algorithm>

#include "world/network/trial.hpp"

namespace robotskin::campaign {
namespace {

// As in network_runs.py.
constexpr std::int64_t step_ns = 10'000'000, forming_ns = 100'000'000, even_ns = 50'000'000, quiet_ns = 500'000'000,
                       longest_ns = 2'000'000'000;

}  // namespace

SettledCase settle(const FaultCase& skin, std::uint32_t even) {
  world::NetworkTrial trial(skin.wiring, skin.options);
  world::TrialReport report;
  std::vector<std::vector<std::uint32_t>> loads;
  std::int64_t changed_ns = 0, now_ns = 0;
  while (now_ns < longest_ns) {
    trial.run_until(now_ns += step_ns);
    report = trial.report();
    if (report.port_loads != loads) {
      loads = report.port_loads;
      changed_ns = now_ns;
    }
    if (now_ns < forming_ns) continue;
    std::uint32_t fullest = 0;
    for (const std::vector<std::uint32_t>& unit : loads)
      for (const std::uint32_t load : unit) fullest = std::max(fullest, load);
    if (now_ns - changed_ns >= (fullest <= even ? even_ns : quiet_ns)) break;
  }
  return {1e-9 * static_cast<double>(now_ns), report.depth_max, loads};
}

}  // namespace robotskin::campaign
