// SPDX-License-Identifier: Apache-2.0
#include "campaign/model_check.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>
#include <stdexcept>

#include "robotskin/feasibility.h"

namespace robotskin::campaign {
namespace {

constexpr int hops_max = 6;  // a longer path than there are cells shows only after a loop
constexpr unsigned root_parent = 7;

// One cell in 32 bits: parent (3: 0 none, 1 + its number, 7 a root), feasible sequence (2) and hops (3), and above them
// a bit for every beacon it has sent since boot, `hops_max` bits a sequence. No beacon yet: no feasible distance.
using Cell = std::uint32_t;

constexpr int beacons_at = 8;

unsigned parent_of(Cell cell) {
  return cell & 7U;
}
rs_distance distance_of(Cell cell) {
  return {static_cast<std::uint16_t>(cell >> 3 & 3U), static_cast<std::uint8_t>(cell >> 5 & 7U)};
}
std::uint32_t beacons_of(Cell cell) {
  return cell >> beacons_at;
}
std::uint32_t beacon_bit(int sequence, int hops) {
  return 1U << ((sequence - 1) * hops_max + hops - 1);
}

struct State {
  std::array<Cell, model_cells_max> cell{};
  std::uint32_t boots = 0;

  bool operator==(const State&) const = default;
};

std::uint64_t hash_of(const State& state) {
  std::uint64_t hash = state.boots;
  for (const Cell cell : state.cell) {
    hash = (hash ^ cell) * 0x9E3779B97F4A7C15U;
    hash ^= hash >> 29;
  }
  return hash;
}

using Permutation = std::array<std::uint8_t, model_cells_max>;  // new number of each cell

struct Symmetry {
  Permutation new_of, old_of;
};

class Exploration {
 public:
  explicit Exploration(const ModelOptions& options) : options_(options) {
    Permutation p;
    std::iota(p.begin(), p.end(), std::uint8_t{0});
    do {
      if (!keeps_graph(p) || std::ranges::is_sorted(p)) continue;
      Symmetry symmetry{p, {}};
      for (unsigned i = 0; i < model_cells_max; ++i) symmetry.old_of[p[i]] = static_cast<std::uint8_t>(i);
      symmetries_.push_back(symmetry);
    } while (std::next_permutation(p.begin(), p.begin() + options.cells));
    table_.resize(1U << 16);
  }

  ModelReport run() {
    add(State{}, 0);
    for (std::size_t at = 0; at < states_.size() && !report_.loop; ++at) {
      if (states_.size() > options_.states_max) break;
      const State state = states_[at];
      successors(state, [&](const State& next, const auto&) {
        ++report_.transitions;
        if (report_.loop) return;
        add(canonical(next), static_cast<std::uint32_t>(at));
        report_.loop = loops(next);
        if (!report_.loop) return;
        loop_from_ = at;
        loop_ = next;
      });
    }
    report_.states = states_.size();
    report_.exhausted = !report_.loop && states_.size() <= options_.states_max;
    if (report_.loop) write_trace();
    return report_;
  }

 private:
  bool keeps_graph(const Permutation& p) const {
    for (int i = 0; i < options_.cells; ++i) {
      if ((options_.roots >> i & 1) != (options_.roots >> p[i] & 1)) return false;
      for (int j = 0; j < options_.cells; ++j)
        if ((options_.linked[i] >> j & 1) != (options_.linked[p[i]] >> p[j] & 1)) return false;
    }
    return true;
  }

  // The same state for all that differ in names only: the least of them.
  State canonical(const State& state) const {
    State best = state;
    for (const Symmetry& symmetry : symmetries_) {
      const auto renamed = [&](std::size_t k) {
        const Cell cell = state.cell[symmetry.old_of[k]];
        const unsigned parent = parent_of(cell);
        if (parent == 0 || parent == root_parent) return cell;
        return (cell & ~Cell{7}) | (symmetry.new_of[parent - 1] + 1U);
      };
      std::size_t k = 0;
      Cell cell = renamed(0);
      while (cell == best.cell[k] && ++k < model_cells_max) cell = renamed(k);
      if (k == model_cells_max || cell > best.cell[k]) continue;
      for (best.cell[k] = cell; ++k < model_cells_max;) best.cell[k] = renamed(k);
    }
    return best;
  }

  bool loops(const State& state) const {
    for (unsigned start = 0; start < static_cast<unsigned>(options_.cells); ++start) {
      unsigned at = start;
      for (int hops = 0; hops <= options_.cells; ++hops) {
        const unsigned parent = parent_of(state.cell[at]);
        if (parent == 0 || parent == root_parent) break;
        at = parent - 1;
        if (at == start) return true;
      }
    }
    return false;
  }

  // R3: what a cell is after adopting a beacon, if the rule (R2) lets it; otherwise as it was.
  static Cell adopted(Cell cell, unsigned parent, int sequence, int hops) {
    const bool unbound = beacons_of(cell) == 0;
    rs_distance bound = distance_of(cell);
    const rs_distance offer{static_cast<std::uint16_t>(sequence), static_cast<std::uint8_t>(hops)};
    const int own = hops + 1;
    if (own > hops_max || !rs_feasible(unbound, bound, offer)) return cell;
    if (unbound || rs_newer(offer.sequence, bound.sequence))
      bound = {offer.sequence, static_cast<std::uint8_t>(own)};
    else
      bound.hops = static_cast<std::uint8_t>(std::min<int>(bound.hops, own));
    return parent | Cell{bound.sequence} << 3 | Cell{bound.hops} << 5 |
           (beacons_of(cell) | beacon_bit(sequence, own)) << beacons_at;
  }

  template <typename Visit>
  void successors(const State& state, const Visit& visit) const {
    State next = state;
    const auto adopt = [&](int i, unsigned parent, int sequence, int hops) {
      next.cell[i] = adopted(state.cell[i], parent, sequence, hops);
      if (next.cell[i] != state.cell[i]) visit(next, [&] { return step_text(i, parent, sequence, hops); });
      next.cell[i] = state.cell[i];
    };
    for (int i = 0; i < options_.cells; ++i) {
      for (int s = 1; s <= options_.sequences; ++s) {
        if ((options_.roots >> i & 1) != 0) adopt(i, root_parent, s, 0);
        for (int j = 0; j < options_.cells; ++j) {
          if ((options_.linked[i] >> j & 1) == 0) continue;
          const std::uint32_t beacons = beacons_of(state.cell[j]);
          for (int h = 1; h <= hops_max; ++h)
            if ((beacons & beacon_bit(s, h)) != 0) adopt(i, static_cast<unsigned>(j) + 1, s, h);
        }
      }
      if (static_cast<int>(state.boots) < options_.boots && state.cell[i] != 0) boot(state, i, visit);
    }
  }

  template <typename Visit>
  void boot(const State& state, int i, const Visit& visit) const {
    State next = state;
    ++next.boots;
    next.cell[i] = 0;
    if (options_.quarantine) {
      for (Cell& cell : next.cell)
        if (parent_of(cell) == static_cast<unsigned>(i) + 1) cell &= ~Cell{7};
    }
    visit(next, [i] { return "cell " + std::to_string(i) + " boots"; });
  }

  static std::string step_text(int i, unsigned parent, int sequence, int hops) {
    const std::string from = parent == root_parent ? "the root" : "cell " + std::to_string(parent - 1);
    return "cell " + std::to_string(i) + " adopts " + from + ", which announced sequence " + std::to_string(sequence) +
           " at " + std::to_string(hops) + " hops";
  }

  void add(const State& state, std::uint32_t from) {
    if (10 * states_.size() >= 7 * table_.size()) grow();
    std::size_t at = hash_of(state) & (table_.size() - 1);
    for (; table_[at] != 0; at = (at + 1) & (table_.size() - 1))
      if (states_[table_[at] - 1] == state) return;
    states_.push_back(state);
    from_.push_back(from);
    table_[at] = static_cast<std::uint32_t>(states_.size());
  }

  void grow() {
    std::vector<std::uint32_t> larger(2 * table_.size());
    for (std::size_t i = 0; i < states_.size(); ++i) {
      std::size_t at = hash_of(states_[i]) & (larger.size() - 1);
      while (larger[at] != 0) at = (at + 1) & (larger.size() - 1);
      larger[at] = static_cast<std::uint32_t>(i + 1);
    }
    table_ = std::move(larger);
  }

  // States are kept up to renaming, so the trace is walked again from the start, with the names of its own steps.
  void write_trace() {
    std::vector<std::size_t> path;
    for (std::size_t at = loop_from_; at != 0; at = from_[at]) path.push_back(at);
    std::reverse(path.begin(), path.end());
    State here{};
    const auto follow = [&](const State& goal) {
      bool done = false;
      State there = here;
      successors(State(here), [&](const State& next, const auto& what) {
        if (done || canonical(next) != goal) return;
        done = true;
        report_.trace.push_back(what());
        there = next;
      });
      here = there;
    };
    for (const std::size_t at : path) follow(states_[at]);
    follow(canonical(loop_));
    std::string circle = "loop:";
    for (unsigned start = 0; start < static_cast<unsigned>(options_.cells); ++start) {
      unsigned at = start;
      std::string text;
      for (int hops = 0; hops <= options_.cells; ++hops) {
        text += " " + std::to_string(at);
        const unsigned parent = parent_of(here.cell[at]);
        if (parent == 0 || parent == root_parent) break;
        at = parent - 1;
        if (at != start) continue;
        report_.trace.push_back(circle + text + " " + std::to_string(start));
        return;
      }
    }
  }

  ModelOptions options_;
  ModelReport report_;
  std::vector<Symmetry> symmetries_;  // other than leaving all as it is
  std::vector<State> states_;
  std::vector<std::uint32_t> from_;   // by state: the one it was first reached from
  std::vector<std::uint32_t> table_;  // 1 + number of a state, by hash; 0: free
  std::size_t loop_from_ = 0;
  State loop_;
};

int ports_used(const ModelOptions& graph, int cell) {
  return std::popcount(graph.linked[cell]) + (graph.roots >> cell & 1);
}

// `part` is in `whole` under some renaming.
bool is_part(const ModelOptions& part, const ModelOptions& whole) {
  Permutation p;
  std::iota(p.begin(), p.end(), std::uint8_t{0});
  do {
    bool inside = true;
    for (int i = 0; i < part.cells && inside; ++i) {
      if ((part.roots >> i & 1) != 0 && (whole.roots >> p[i] & 1) == 0) inside = false;
      for (int j = 0; j < part.cells && inside; ++j)
        if ((part.linked[i] >> j & 1) != 0 && (whole.linked[p[i]] >> p[j] & 1) == 0) inside = false;
    }
    if (inside) return true;
  } while (std::next_permutation(p.begin(), p.begin() + part.cells));
  return false;
}

}  // namespace

ModelReport check_model(const ModelOptions& options) {
  const auto within = [](const char* name, long value, long low, long high) {
    if (value < low || value > high)
      throw std::invalid_argument(std::string(name) + " " + std::to_string(value) + ": must be " + std::to_string(low) +
                                  " to " + std::to_string(high));
  };
  within("cells", options.cells, 1, model_cells_max);
  within("sequences", options.sequences, 1, 3);
  within("boots", options.boots, 0, 3);
  within("states_max", static_cast<long>(options.states_max), 1, 1'000'000'000);
  within("roots", options.roots, 1, (1 << options.cells) - 1);
  for (int i = 0; i < model_cells_max; ++i)
    for (int j = 0; j < 8; ++j) {
      if ((options.linked[i] >> j & 1) == 0) continue;
      if (i == j || i >= options.cells || j >= options.cells || (options.linked[j] >> i & 1) == 0)
        throw std::invalid_argument("link " + std::to_string(i) + "-" + std::to_string(j) +
                                    ": joins two cells, and both name it");
    }
  return Exploration(options).run();
}

std::vector<ModelOptions> largest_graphs(int cells) {
  if (cells < 1 || cells > model_cells_max)
    throw std::invalid_argument("cells " + std::to_string(cells) + ": must be 1 to 5");
  std::vector<ModelOptions> all;
  const int pairs = cells * (cells - 1) / 2;
  for (const std::uint8_t roots : {std::uint8_t{1}, std::uint8_t{3}}) {
    if (roots >> cells != 0) continue;
    for (int links = (1 << pairs) - 1; links >= 0; --links) {  // more links come first
      ModelOptions graph;
      graph.cells = cells;
      graph.roots = roots;
      for (int i = 0, pair = 0; i < cells; ++i)
        for (int j = i + 1; j < cells; ++j, ++pair)
          if ((links >> pair & 1) != 0) {
            graph.linked[i] |= static_cast<std::uint8_t>(1 << j);
            graph.linked[j] |= static_cast<std::uint8_t>(1 << i);
          }
      bool fits = true;
      for (int i = 0; i < cells; ++i) fits = fits && ports_used(graph, i) <= RS_PORTS;
      if (fits) all.push_back(graph);
    }
  }
  std::vector<ModelOptions> largest;
  for (const ModelOptions& graph : all) {
    const bool inside_other = std::ranges::any_of(
        all, [&](const ModelOptions& other) { return is_part(graph, other) && !is_part(other, graph); });
    const bool known = std::ranges::any_of(largest, [&](const ModelOptions& other) { return is_part(graph, other); });
    if (!inside_other && !known) largest.push_back(graph);
  }
  return largest;
}

}  // namespace robotskin::campaign
