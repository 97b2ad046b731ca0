// SPDX-License-Identifier: Apache-2.0
// One run of a network with its faults, measured: how it forms, heals, and serves the host.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "world/network/network.hpp"
#include "world/network/path_survey.hpp"

namespace robotskin::world {

// Of cells that ran and were in reach all the time since the fault, until the next fault strikes. Milliseconds.
struct FaultOutcome {
  Fault fault;
  double recovery_ms = 0;           // from the fault until every such cell has a way again, for good
  double outage_ms = 0;             // longest time during which one had none
  double rejoin_ms = 0;             // until every cell in reach has a way, those that were off or out of reach too
  std::uint32_t cells_cut_off = 0;  // at once, at most
  bool healed = true;               // every cell in reach had a way at the end
};

struct TrialReport {
  double seconds = 0;
  double formation_ms = -1;  // until every cell in reach first had its shortest way, -1: never
  double named_ms = -1;      // and an id
  std::vector<FaultOutcome> outcomes;
  double recovery_max_ms = 0;   // of outcomes
  bool whole = false;           // every cell in reach has a way at the end
  std::int32_t depth_max = 0;   // hops along parents at the end
  double extra_depth_mean = 0;  // of these over the fewest possible
  std::int32_t extra_depth_max = 0;
  std::vector<std::vector<std::uint32_t>> port_loads;  // by unit and port: cells that report through it at the end
  std::uint32_t cells_in_reach = 0;

  // Samples: from the first formation on, of clock and event frames.
  std::uint64_t samples_sent = 0, samples_heard = 0, samples_lost = 0, samples_twice = 0;
  double host_gap_ms = 0;            // longest silence at the host of a cell that was in reach and ran all the time
  std::vector<double> cell_gap_ms;   // (N) of every cell, -1: never heard twice
  std::vector<std::uint8_t> steady;  // (N) in reach and running all the time
  double latency_mean_ms = 0, latency_p99_ms = 0, latency_max_ms = 0;  // from sampling to the section unit's port
  std::vector<std::uint64_t> latency_counts;  // samples by that latency, 10 us each; beyond the last one in it

  std::uint64_t frames_lost = 0;     // on wires
  std::uint64_t frames_dropped = 0;  // by full queues
  std::uint32_t queue_peak = 0;
  NetworkCounts counts;
  std::uint64_t log_hash = 0;
};

// Cells read what lies still in the air; the datagrams are not taken. Ways are surveyed whenever a parent or a wire has
// changed, at most every 25 us.
class NetworkTrial : private SampleSource, private DatagramSink, private Observer {
 public:
  // Section units send unasked. Throws FaultError.
  NetworkTrial(const Wiring& wiring, NetworkOptions options);

  void run_until(std::int64_t end_ns);
  // Samples, gaps and latencies count from now on: those of the settled network, say, without the time before.
  void measure_anew();
  TrialReport report();
  Network& network() { return network_; }
  const Network& network() const { return network_; }

 private:
  static constexpr std::int64_t survey_ns = 25000;
  static constexpr std::size_t sequences = 256;  // of sample frames, by 8 bits
  static constexpr std::int64_t latency_bin_ns = 10000;

  struct Sample {
    std::int64_t sampled_ns = -1;  // -1: none
    bool heard = false;
  };
  struct Listener {  // of one cell
    std::int64_t heard_ns = -1;
    std::int64_t gap_ns = -1;
    std::uint8_t sequence = 0, parent_port = 0;
    std::uint16_t id = 0;
    bool steady = true;
    bool strayed = false;  // out of reach since the last fault struck
    std::array<Sample, sequences> samples;
  };

  static NetworkOptions prepared(NetworkOptions options);
  bool sample(std::size_t cell, std::int64_t time_ns, rs_sample& sample) override;
  void send(std::size_t unit, std::int64_t time_ns, std::span<const std::uint8_t> datagram) override;
  void cell_stepped(const Network&, std::size_t cell, const rs_input&, const rs_output&) override;
  void frame_ended(const Network&, WireEnd from, WireEnd to, const std::uint8_t* frame, FrameFate) override;
  void fault_applied(const Network&, const Fault&, int phase) override;
  void note_id(std::size_t cell, std::uint16_t id);
  Listener* listener_of(std::size_t unit, const std::uint8_t* frame);
  void survey();

  std::vector<Listener> cells_;
  std::vector<std::uint16_t> group_of_cell_;
  std::vector<std::vector<std::int32_t>> cell_by_id_;  // by group
  std::vector<std::uint16_t> group_of_unit_;
  TrialReport report_;
  std::vector<std::uint64_t> latencies_;  // counts by bins
  std::int64_t struck_ns_ = -1, broken_since_ns_ = -1, next_survey_ns_ = 0;
  bool changed_ = true, rejoining_ = false;
  Network network_;  // after all that it calls upon
  PathSurvey paths_;
  std::uint64_t revision_ = 0;
};

}  // namespace robotskin::world
