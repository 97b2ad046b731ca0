// SPDX-License-Identifier: Apache-2.0
// Every sample from the cell that took it to the host: true, once, in order, and without faults none missing (I11).
//
// It is also where the cells get their readings: each carries the cell's number and the sample's, and a sum of both, so
// that what arrives proves itself.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "campaign/cable_loads.hpp"
#include "campaign/fault_case.hpp"
#include "campaign/ground_truth.hpp"
#include "campaign/invariants.hpp"
#include "campaign/line_losses.hpp"
#include "campaign/recovery_checker.hpp"
#include "campaign/route_checker.hpp"

namespace robotskin::campaign {

// A sample by the cell that took it and its number there.
struct TakenSample {
  std::size_t cell = 0;
  std::uint16_t number = 0;
};

class SampleLedger : public world::SampleSource {
 public:
  static constexpr std::size_t kept = 256;              // samples of a cell
  static constexpr std::int64_t delivery_ns = 40 * ms;  // from cell to host, at most
  // After each fault trees may form anew, and lines repeat frames: then at most one queue of samples may overflow, and
  // one processor's room for frames that wait, on the way to the cable where all of it meets. A tree that stays within
  // load has no more on its way at a time than that.
  static constexpr std::uint64_t crowded_out_max = RS_QUEUE_DATA + 48;
  // What one damaged cell holds of others, and what it says of itself until it is healed.
  static constexpr std::uint64_t excused_max = 256;

  SampleLedger(const FaultCase& drawn, BreakLog& breaks);

  bool sample(std::size_t cell, std::int64_t time_ns, rs_sample& sample) override;

  // Whether the cell has sent a sample of its own.
  bool cell_stepped(const world::Network& network, std::size_t cell, const rs_input& input);
  void datagram(const world::Network& network, const GroundTruth& ground, const RouteChecker& routes,
                std::span<const std::uint8_t> datagram);
  // What a frame on its way to the host says to be; a frame of no cell says cell 0, number 0, which is none.
  static TakenSample taken_in(const std::uint8_t* frame);
  static TakenSample taken_in(const rs_sample& own);
  // When the sample of a frame was taken; none if it is no sample that is known.
  std::optional<std::int64_t> taken_ns(const std::uint8_t* frame) const;
  // It found a queue full of repeated ones, or a processor that may have too much to do.
  void crowded_out(TakenSample sample);
  // A fault has struck, or goes on, and is known to the ground; not yet to `recovery`.
  void struck(const world::Network& network, GroundTruth& ground, const RecoveryChecker& recovery,
              const CableLoads& loads);
  // Looks for samples that are missing by now. Where only the protocol can have lost them each counts; on lossy lines,
  // and of cables that have more than they carry, they are counted.
  void poll(const world::Network& network, const GroundTruth& ground, const RecoveryChecker& recovery,
            const CableLoads& loads);
  void finish(const world::Network& network, const CableLoads& loads);  // at the end

  std::uint64_t taken() const { return taken_; }
  std::uint64_t delivered() const { return delivered_; }
  std::uint64_t repeated() const { return repeated_; }  // events that came again, marked so
  std::uint64_t excused() const { return excused_; }    // samples that were false, as memory had been damaged
  // Samples that were due, and found no room in a tree within load, after one fault at most.
  std::uint64_t crowded_out_most() const { return crowded_out_most_; }
  std::uint64_t lost_overloaded() const { return lost_overloaded_; }  // that were due, in trees that had too much

 private:
  struct Entry {
    std::int64_t time_ns = 0;
    std::uint16_t number = 0, source = 0;
    std::uint8_t delivered = 0, sequence = 0;
    bool sent = false, retransmitted = false, crowded_out = false;
  };
  struct Cell {
    std::array<Entry, kept> entry;
    std::uint16_t next = 1, checked = 1, last_delivered = 0;
    std::uint8_t sequence = 0;
    std::uint16_t id = 0;
    std::int64_t named_ns = 0;
  };

  // A failure that must cost no event: the only one of a run, of a link or a cell.
  struct Failure {
    bool possible = false, judged = false;
    std::int32_t victim = -1;  // the cell that fails
    std::int64_t time_ns = 0;
    std::vector<std::uint8_t> spared;  // cells that run and can be reached all the time
  };

  bool must_arrive(const GroundTruth& ground, const RecoveryChecker& recovery, std::size_t cell,
                   const Entry& entry) const;
  bool must_be_kept(const GroundTruth& ground, std::size_t cell, const Entry& entry, bool may_lose) const;
  void count_crowded_out(std::int64_t now_ns, std::size_t cell);
  void count_taken(std::int64_t now_ns);
  std::int64_t kept_copies(std::int64_t now_ns) const;
  bool touched(std::size_t cell, std::int64_t time_ns) const;
  void record(const world::Network& network, const GroundTruth& ground, const RouteChecker& routes,
              const rs_clock& frame);

  BreakLog& breaks_;
  std::vector<Cell> cells_;
  Workload workload_;
  std::uint64_t seed_;
  bool whole_lines_;
  LineLosses losses_;
  Failure failure_;
  void excuse(const world::Network& network, const GroundTruth& ground, std::size_t cell);
  struct TakenIn {
    std::int64_t ms = -1, samples = 0;
  };
  std::array<TakenIn, 16> taken_in_;  // by millisecond
  std::uint64_t taken_ = 0, delivered_ = 0, repeated_ = 0, excused_ = 0;
  std::uint64_t crowded_out_ = 0, crowded_out_most_ = 0, sent_overloaded_ = 0, lost_overloaded_ = 0;
};

}  // namespace robotskin::campaign
