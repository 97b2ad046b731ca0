// SPDX-License-Identifier: Apache-2.0
// What must be true of the network whatever happens to it, and what is told when it is not.
//
// What belongs together has one number. Some hold at every event ("nothing false may be accepted"), others once faults
// are over ("whole in bounded time"); the watch that checks one says when.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace robotskin::campaign {

// X(name, number, what must be true)
// clang-format off
#define ROBOTSKIN_INVARIANTS(X)                                                                                    \
  X(acyclic, 1, "parent pointers form no circle")                                                                  \
  X(distance_order, 2, "a parent's feasible distance comes strictly before its child's")                           \
  X(true_adoption, 3, "a cell's hops and tick are those of a beacon that arrived at its parent port, one hop on")  \
  X(hops_left, 3, "no frame runs out of hops, and no sample comes from the own parent")                            \
  X(own_child, 4, "no cell adopts a neighbour that says to be its child")                                          \
  X(quarantine, 4, "no cell has a parent before its quarantine is over")                                           \
  X(true_tick, 5, "every tick in a cell was issued by the root it names")                                          \
  X(tick_window, 5, "no tick runs far ahead of a parent that is alive")                                            \
  X(rejoined, 6, "without faults every cell that can be reached has a whole path to a section unit")               \
  X(shortest, 7, "while forming, every cell has its breadth-first distance")                                       \
  X(depth_cap, 8, "no move to another tree goes deeper than the cap, and settled cells have the nearest parent of theirs") \
  X(tree_sizes, 9, "the sizes that roots know add up to the cells attached")                                       \
  X(levelling_bound, 10, "by levelling no port gets fuller than the fullest, or than the mean and what was granted") \
  X(levelling_progress, 10, "levelled loads are no less even than before, and moves are granted while a leaf could go to a smaller tree")                                         \
  X(true_sample, 11, "every sample that the host gets was taken by the cell it names")                             \
  X(exactly_once, 11, "no sample is delivered twice")                                                              \
  X(in_order, 11, "samples of a cell arrive in order while its path stays")                                        \
  X(none_lost, 11, "without faults no sample is lost, whichever cell moves")                                       \
  X(obeyed, 11, "without faults what the host orders reaches every cell with a way")                               \
  X(sampled, 11, "without faults every cell with a way has an id, and sends within its period times the divisor")  \
  X(torque_count, 12, "a torque sum has as many different cells in it as it says")                                 \
  X(torque_once, 12, "no cell is in two sums of one epoch")                                                        \
  X(torque_complete, 12, "without faults every cell is in each epoch's sums")                                      \
  X(torque_true, 12, "a cell's own torques are what double precision says of its touch and the host's posture, and whole sums add them up") \
  X(event_kept, 11, "no event is lost to a single failure of a link or of another cell")                           \
  X(queue_bound, 13, "queues stay within their size")                                                              \
  X(waiting, 13, "no sample waits 8 ms in a cell at up to 66 cells a port")                                        \
  X(beacon_rate, 14, "at most four beacons a millisecond and wire")                                                \
  X(control_share, 14, "control takes at most its share of each wire")                                             \
  X(recovery, 15, "cut-off cells are back within the bound for their distance")                                    \
  X(legal_again, 16, "60 ms after any corruption of a cell's memory everything holds again")                       \
  X(host_topology, 17, "the host's picture is the real graph 1.1 s after the last change")                         \
  X(overload, 18, "the rate divisor takes an overload away before queues lose samples")                            \
  X(true_tag, 19, "keys and tags are those that the published page states")                                           \
  X(forged, 19, "a frame under a wrong tag changes nothing that tags protect")                                     \
  X(replayed, 19, "a tagged frame that is played again changes nothing that tags protect")
// clang-format on

#define ROBOTSKIN_INVARIANT_NAME(name, number, text) name,
enum class Invariant : std::uint8_t { ROBOTSKIN_INVARIANTS(ROBOTSKIN_INVARIANT_NAME) };
#undef ROBOTSKIN_INVARIANT_NAME

#define ROBOTSKIN_INVARIANT_ONE(name, number, text) +1
inline constexpr std::size_t invariant_count = 0 ROBOTSKIN_INVARIANTS(ROBOTSKIN_INVARIANT_ONE);
#undef ROBOTSKIN_INVARIANT_ONE

std::string_view name_of(Invariant invariant);  // "acyclic"
int number_of(Invariant invariant);             // 1, for I1
std::string_view text_of(Invariant invariant);

struct Value {
  std::string_view name;
  std::int64_t value;
};

// One invariant broken at one time.
struct Break {
  Invariant invariant = Invariant::acyclic;
  std::int64_t time_ns = 0;
  std::vector<std::size_t> cells;  // concerned
  std::vector<Value> values;

  std::string text() const;  // one line
};

// The breaks of a run, of each invariant the first few; it goes on counting.
class BreakLog {
 public:
  static constexpr std::size_t kept_each = 3;

  void add(Invariant invariant, std::int64_t time_ns, std::initializer_list<std::size_t> cells,
           std::initializer_list<Value> values);

  const std::vector<Break>& kept() const { return kept_; }
  std::uint64_t count() const { return count_; }
  std::uint64_t count(Invariant invariant) const { return counts_[static_cast<std::size_t>(invariant)]; }

 private:
  std::vector<Break> kept_;
  std::array<std::uint64_t, invariant_count> counts_{};
  std::uint64_t count_ = 0;
};

}  // namespace robotskin::campaign
