// SPDX-License-Identifier: Apache-2.0
// Runs seeds of the campaign, or the model check, with the firmware it was linked with; one JSON object a line.
//
//   campaign_NAME run FIRST COUNT [INVARIANT ...]   until one of these invariants (none given: any) is broken
//   campaign_NAME survey FIRST COUNT                all breaks of each
//   campaign_NAME case < TEXT                       all breaks of a case as text
//   campaign_NAME levelling LOADS/LOADS/...         breaks of loads by root (a,b,c) of one weighing after the other
//   campaign_NAME settle EVEN < TEXT                the loads of a case's cables once they stay; even: at so many cells
//   campaign_NAME hash SEED                         the log hash of its run
//   campaign_NAME model CELLS SEQUENCES BOOTS QUARANTINE   every largest graph on so many cells, until a loop
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>
#include <vector>

#include "campaign/balance_checker.hpp"
#include "campaign/case_text.hpp"
#include "campaign/model_check.hpp"
#include "campaign/run_case.hpp"
#include "campaign/settle.hpp"

namespace {

using namespace robotskin::campaign;

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

// A name that no invariant has would be broken by no seed.
bool are_invariants(const std::vector<std::string>& names) {
  std::vector<std::string> known;
  for (std::size_t i = 0; i < invariant_count; ++i) known.emplace_back(name_of(static_cast<Invariant>(i)));
  for (const std::string& name : names) {
    if (std::ranges::find(known, name) != known.end()) continue;
    std::fprintf(stderr, "'%s' is no invariant; these are:", name.c_str());
    for (const std::string& one : known) std::fprintf(stderr, " %s", one.c_str());
    std::fputs("\n", stderr);
    return false;
  }
  return true;
}

int run(std::uint64_t first, std::uint64_t count, const std::vector<std::string>& wanted) {
  if (!are_invariants(wanted)) return 2;
  const std::clock_t start = std::clock();
  std::uint64_t seed = first, seeds = 0;
  std::string found;
  for (; seeds < count && found.empty(); ++seed) {
    const FaultCase drawn = draw_case(seed);
    const CaseReport report = run_case(drawn);
    ++seeds;
    for (const Break& b : report.breaks) {
      if (!wanted.empty() && std::ranges::find(wanted, name_of(b.invariant)) == wanted.end()) continue;
      found = ", \"seed\": " + std::to_string(seed) + ", \"invariant\": " + quoted(std::string(name_of(b.invariant))) +
              ", \"break\": " + quoted(b.text()) + ", \"case\": " + quoted(drawn.text());
      break;
    }
  }
  std::printf("{\"seeds\": %llu, \"cpu_s\": %.3f%s}\n", static_cast<unsigned long long>(seeds),
              static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, found.c_str());
  return 0;
}

void tell(const FaultCase& drawn) {
  const CaseReport report = run_case(drawn);
  for (const Break& b : report.breaks)
    std::printf("{\"seed\": %llu, \"invariant\": %s, \"break\": %s, \"case\": %s}\n",
                static_cast<unsigned long long>(drawn.seed), quoted(std::string(name_of(b.invariant))).c_str(),
                quoted(b.text()).c_str(), quoted(drawn.text()).c_str());
}

int survey(std::uint64_t first, std::uint64_t count) {
  const std::clock_t start = std::clock();
  for (std::uint64_t seed = first; seed < first + count; ++seed) tell(draw_case(seed));
  std::printf("{\"seeds\": %llu, \"cpu_s\": %.3f}\n", static_cast<unsigned long long>(count),
              static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  return 0;
}

int levelling(const std::string& weighings) {
  BreakLog breaks;
  BalanceChecker watch(breaks);
  std::int64_t now_ns = 0;
  std::vector<std::uint32_t> loads;
  std::string number;
  for (const char c : weighings + "/") {
    if (c != ',' && c != '/') {
      number += c;
      continue;
    }
    loads.push_back(static_cast<std::uint32_t>(std::stoul(number)));
    number.clear();
    if (c != '/') continue;
    watch.weigh(now_ns += 50 * ms, loads, true);
    loads.clear();
  }
  watch.finish(now_ns + 100 * ms);
  for (const Break& b : breaks.kept())
    std::printf("{\"invariant\": %s}\n", quoted(std::string(name_of(b.invariant))).c_str());
  return 0;
}

std::string text_at_input() {
  std::string text;
  for (int c = std::getchar(); c != EOF; c = std::getchar()) text += static_cast<char>(c);
  return text;
}

int run_text() {
  tell(case_of(text_at_input()));
  return 0;
}

int settle_text(std::uint32_t even) {
  const SettledCase settled = settle(case_of(text_at_input()), even);
  std::string loads;
  for (const std::vector<std::uint32_t>& unit : settled.loads) {
    std::string ports;
    for (const std::uint32_t load : unit) ports += (ports.empty() ? "" : ", ") + std::to_string(load);
    loads += (loads.empty() ? "[" : ", [") + ports + "]";
  }
  std::printf("{\"seconds\": %.3f, \"depth\": %d, \"loads\": [%s]}\n", settled.seconds, settled.depth, loads.c_str());
  return 0;
}

int model(int cells, int sequences, int boots, bool quarantine) {
  for (ModelOptions graph : largest_graphs(cells)) {
    graph.sequences = sequences;
    graph.boots = boots;
    graph.quarantine = quarantine;
    const ModelReport report = check_model(graph);
    std::string trace;
    for (const std::string& line : report.trace) trace += (trace.empty() ? "" : ", ") + quoted(line);
    std::printf("{\"states\": %llu, \"exhausted\": %s, \"loop\": %s, \"trace\": [%s]}\n",
                static_cast<unsigned long long>(report.states), report.exhausted ? "true" : "false",
                report.loop ? "true" : "false", trace.c_str());
    if (report.loop) break;
  }
  return 0;
}

}  // namespace

int main(int count, char** values) {
  const auto number = [&](int i) { return i < count ? std::strtoull(values[i], nullptr, 10) : 0ULL; };
  if (count >= 4 && std::strcmp(values[1], "run") == 0)
    return run(number(2), number(3), std::vector<std::string>(values + 4, values + count));
  if (count == 4 && std::strcmp(values[1], "survey") == 0) return survey(number(2), number(3));
  if (count == 3 && std::strcmp(values[1], "levelling") == 0) return levelling(values[2]);
  if (count == 2 && std::strcmp(values[1], "case") == 0) return run_text();
  if (count == 3 && std::strcmp(values[1], "settle") == 0) return settle_text(static_cast<std::uint32_t>(number(2)));
  if (count == 3 && std::strcmp(values[1], "hash") == 0) {
    std::printf("{\"log_hash\": \"%016llx\"}\n",
                static_cast<unsigned long long>(run_case(draw_case(number(2))).log_hash));
    return 0;
  }
  if (count == 6 && std::strcmp(values[1], "model") == 0)
    return model(static_cast<int>(number(2)), static_cast<int>(number(3)), static_cast<int>(number(4)), number(5) != 0);
  std::fprintf(
      stderr,
      "usage: %s run FIRST COUNT [INVARIANT ...] | survey FIRST COUNT | case | settle EVEN | hash SEED | model "
      "CELLS SEQUENCES BOOTS QUARANTINE\n",
      values[0]);
  return 2;
}
