// SPDX-License-Identifier: Apache-2.0
// Explores every state of a small network under the parent rule of the firmware (rs_feasible, the text the cells run).
//
// The network is the worst one there can be: every beacon that a cell has ever sent since its boot may arrive at any of
// its neighbours at any time, once, often or never. That covers loss, delay, reordering and repetition, silent death of
// links, and every policy of switching, since a cell may adopt whatever the rule lets it. A cell that loses its parent
// keeps its feasible distance; it is left pointing there, as a pointer more can only close a loop more. Roots send any
// tick they like, which covers roots that disagree and any number of ports of them. A graph behaves in every way a part
// of it does, so the largest graphs on so many cells speak for all others (`largest_graphs`).
//
// A boot clears what a cell knows. With quarantine its children have noticed before it acts (R9): they let go, and its
// old beacons are void. Without, they still point at it, and its old beacons still arrive.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace robotskin::campaign {

inline constexpr int model_cells_max = 5;

struct ModelOptions {
  int cells = 4;                                          // 1 to 5
  std::array<std::uint8_t, model_cells_max> linked = {};  // bit j of linked[i]: a wire joins cells i and j
  std::uint8_t roots = 1;                                 // bit i: cell i has a section unit's port
  int sequences = 2;                                      // ticks, 1 to 3
  int boots = 0;                                          // reboots in a run, at most
  bool quarantine = true;
  std::uint64_t states_max = 50'000'000;
};

struct ModelReport {
  std::uint64_t states = 0;       // explored, up to the symmetries of the graph
  std::uint64_t transitions = 0;  // taken
  bool exhausted = false;         // nothing is left to explore
  bool loop = false;
  std::vector<std::string> trace;  // the shortest way to the loop, a step a line
};

// Throws std::invalid_argument, naming the value, for options outside their ranges or links that only one side has.
ModelReport check_model(const ModelOptions& options);

// The graphs on so many cells, of 4 ports each, with the ports of one or two cells at section units, to which no wire
// can be added; every other such network is a part of one of them. Up to renaming of cells.
std::vector<ModelOptions> largest_graphs(int cells);

}  // namespace robotskin::campaign
