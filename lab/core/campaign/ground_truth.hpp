// SPDX-License-Identifier: Apache-2.0
// The ground truth of a run, from wires, power and faults alone: what can reach what, and since when it has been quiet.
//
// It knows the published periods of the protocol (timing.h), to say how long a repair may take, and nothing else of it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "campaign/line_losses.hpp"
#include "campaign/processing_times.hpp"
#include "robotskin/timing.h"
#include "world/network/fault_type.hpp"
#include "world/network/network.hpp"

namespace robotskin::campaign {

inline constexpr std::int64_t us = 1000, ms = 1000 * us;
// A frame's way through a cell that computes in no time, at most: its own time on the line, and that of another one.
inline constexpr std::int64_t idle_hop_ns = 120 * us;
// A cell that was granted a move holds back the ticks of its tree for so long, and cells behind it wait as long.
inline constexpr std::int64_t held_ns = RS_HOLD_US * us * 102 / 100;
inline constexpr std::int64_t legal_again_ns = 60 * ms;
inline constexpr int memory_reach = 4;

class GroundTruth : private world::FaultWitness {
 public:
  static constexpr std::int32_t no_wire = -1;

  // `frame_loss`: the share of frames that a line loses by chance.
  GroundTruth(const world::Network& network, ProcessingTimes times, double frame_loss);

  // A tick's way through a cell, at most.
  std::int64_t hop_ns() const { return idle_hop_ns + times_.tick_ns; }
  std::int64_t longest_input_ns() const { return times_.longest_ns; }
  // Without a hop: four heartbeats until a silent neighbour is noticed, one for the check, one for the next tick. Each
  // of the three may wait for the input that the processor has in hand.
  std::int64_t repair_ns() const { return 6 * ms + 3 * times_.longest_ns; }

  // ---- The checkers tells ----
  // A step may come between the overwriting of memory and the word of it, so that its time is known beforehand.
  void expect(const std::vector<world::Fault>& faults);
  void booted(std::size_t cell);
  void fault(const world::Fault& fault, int phase);
  void untold();                   // a tick came in that names no root, and so bears no tag: a cell may let go
  void planted(std::size_t wire);  // a frame of no neighbour's came in there: it keeps a link up that is cut one way
  void forged(std::size_t wire);   // the same under a wrong tag: so many close the port
  void granted();                  // a cell may move
  // A frame there, on lines that lose or damage some. Two in a row may be all that kept the link up.
  void frame_ended(std::size_t wire, bool whole);
  void misled();  // a cell alone for long may follow a tick from earlier
  void settle();  // after either of them

  // ---- Wires: 4 a cell, then 15 a section unit ----
  std::size_t wire_of_cell(std::size_t cell, unsigned port) const { return RS_PORTS * cell + port - 1; }
  std::size_t wire_of(world::WireEnd end) const {
    return end.at == world::WireEnd::At::cell
               ? wire_of_cell(end.index, end.port)
               : RS_PORTS * cells_ + RS_SECTION_UNIT_PORTS_MAX * end.index + end.port - 1;
  }
  std::size_t wire_count() const { return far_.size(); }
  // The wire that leads back, no_wire: open end.
  std::int32_t far(std::size_t wire) const { return far_[wire]; }
  bool is_cell(std::size_t wire) const { return wire < RS_PORTS * cells_; }
  static std::size_t cell_of(std::size_t wire) { return wire / RS_PORTS; }
  // Since when the wire leads where it does.
  std::int64_t moved_ns(std::size_t wire) const { return moved_ns_[wire]; }
  // Frames go both ways between two that run.
  bool joined(std::size_t wire) const { return joined_[wire]; }
  // Joined for so long that the link is up, and let in again if it has been flapping.
  bool ready(std::size_t wire, std::int64_t now_ns) const { return joined_[wire] && ready_ns_[wire] <= now_ns; }

  // ---- Cells ----
  bool runs(std::size_t cell) const { return runs_[cell]; }  // on, or a zombie
  bool is_zombie(std::size_t cell) const { return zombie_[cell]; }
  std::int64_t booted_ns(std::size_t cell) const { return booted_ns_[cell]; }
  // What cells that have booted lately ask for costs processors so much time, in which samples and sums may be lost.
  std::int64_t catch_up_ns(std::int64_t now_ns) const;
  // It may let go of its links until then, as a cell does that is slow or was damaged.
  std::int64_t shaken_until_ns(std::size_t cell) const { return shaken_until_ns_[cell]; }
  // Hops to a section unit that runs over wires that have been ready since before `now_ns` - `margin_ns`; -1: none.
  const std::vector<std::int32_t>& reach(std::int64_t now_ns, std::int64_t margin_ns);

  // ---- Quiet ----
  std::int64_t disturbed_ns() const { return disturbed_ns_; }  // the last change, or end of a disturbance so far
  bool calm(std::int64_t now_ns) const { return now_ns >= restless_until_ns_; }
  // Cells may be moving from tree to tree.
  bool moving(std::int64_t now_ns) const { return now_ns < moving_until_ns_; }
  // The same without what memory that was overwritten disturbs: of cells that have nothing to do with it.
  bool calm_elsewhere(std::int64_t now_ns) const { return now_ns >= elsewhere_.restless_until_ns; }
  std::int64_t repaired_elsewhere_ns() const { return elsewhere_.repaired_ns + (waits_ ? held_ns : 0); }
  // Repairs may take until then; the checkers adds the hops that the last fault cut off.
  std::int64_t repaired_ns() const { return repaired_ns_ + (waits_ ? held_ns : 0); }
  // `hops` from what has a way to what has none. Before that, word that a way is lost goes down it, so many hops: on
  // the lines within the four heartbeats, but each processor on the way takes its time. For a tick that is lost the
  // next one comes. Where cables carry more than they can, each of these processors has another input in hand.
  void allow_hops(std::int32_t hops, std::int32_t word_hops, bool overloaded) {
    const std::int64_t way_ns = hops * hop_ns() + word_hops * times_.tick_ns +
                                ticks_lost(frame_loss_, hops) * RS_TICK_US * us +
                                (overloaded ? (hops + word_hops) * times_.longest_ns : 0);
    repaired_ns_ = std::max(repaired_ns_, base_ns_ + way_ns);
    elsewhere_.repaired_ns = std::max(elsewhere_.repaired_ns, elsewhere_.base_ns + way_ns);
  }
  // Memory was overwritten: what is false until then may come from that.
  bool lawless(std::int64_t now_ns) const { return now_ns < lawless_until_ns_ || about_to_be_overwritten(now_ns); }
  // The same of a cell within `memory_reach` wires of the one that was damaged. Farther ones keep every law.
  bool lawless(std::int64_t now_ns, std::size_t cell) const {
    return now_ns < lawless_cell_ns_[cell] || about_to_be_overwritten(now_ns);
  }
  // So many wrong tags have come in that the port may close, and whatever used it lets go of it.
  bool tags_spent(std::size_t wire) const { return forged_[wire] > RS_TAGS_BUDGET; }
  std::int32_t memory_faults() const { return memory_faults_; }
  std::int64_t lawless_until_ns() const { return lawless_until_ns_; }
  std::int64_t lawless_until_ns(std::size_t cell) const { return lawless_cell_ns_[cell]; }
  bool samples_disturbed_since(std::int64_t since_ns) const { return samples_disturbed_ns_ >= since_ns; }
  std::uint64_t revision() const { return revision_; }

 private:
  void disturbed(std::int64_t for_ns, std::int64_t longer_ns) override;
  void links_fall(const world::Fault& fault, std::int64_t for_ns, std::int32_t downs) override;
  void silent(const world::Fault& fault, std::int64_t for_ns) override;
  void links_of_cell_fall(std::size_t cell, std::int64_t for_ns, std::int32_t downs) override;
  void processor_stuck(std::size_t cell, bool stuck) override;
  void memory_overwritten(std::size_t cell) override;
  void samples_disturbed(std::int64_t for_ns) override;

  bool about_to_be_overwritten(std::int64_t now_ns) const {
    return now_ns >= next_overwritten_ns_ && now_ns < next_overwritten_ns_ + us;
  }
  // `elsewhere`: cells far from where it strikes may feel it too.
  void disturb(std::int64_t for_ns, std::int64_t repair, bool elsewhere = true);
  void shake(std::size_t wire, std::int64_t quarantine_ns, std::int32_t downs);
  void look_at(std::size_t wire);
  std::vector<std::size_t> wires_of(const world::Fault& fault) const;

  const world::Network& network_;
  ProcessingTimes times_;
  double frame_loss_;
  std::size_t cells_;
  std::vector<std::int32_t> far_, downs_, forged_;
  std::vector<std::uint8_t> joined_;
  std::vector<std::int64_t> ready_ns_, moved_ns_, heard_ns_;
  std::vector<std::uint8_t> runs_, zombie_;
  std::vector<std::int64_t> booted_ns_, shaken_until_ns_, lawless_cell_ns_;
  std::vector<std::int32_t> depth_, queue_;
  std::int64_t next_ready_ns_ = 0, depth_since_ns_ = -1;
  std::uint64_t depth_revision_ = ~std::uint64_t{0};
  std::int64_t disturbed_ns_ = 0, restless_until_ns_ = 0, base_ns_ = 0, repaired_ns_ = 0;
  struct {
    std::int64_t restless_until_ns = 0, base_ns = 0, repaired_ns = 0;
  } elsewhere_;                               // than near memory that was overwritten
  std::vector<std::int64_t> overwritten_ns_;  // the times to come, latest first
  std::int64_t next_overwritten_ns_ = std::numeric_limits<std::int64_t>::max() / 2;
  std::int64_t moving_until_ns_ = -1;
  bool waits_ = false;  // the present repair, for a move
  std::int64_t lawless_until_ns_ = 0, samples_disturbed_ns_ = 0;
  std::int32_t memory_faults_ = 0;
  std::uint64_t revision_ = 0;
};

}  // namespace robotskin::campaign
