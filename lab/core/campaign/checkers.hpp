// SPDX-License-Identifier: Apache-2.0
// Watches one run: hands every event to the checkers, and calls those that look now and then.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "campaign/balance_checker.hpp"
#include "campaign/beacon_log.hpp"
#include "campaign/cable_loads.hpp"
#include "campaign/control_meter.hpp"
#include "campaign/fault_case.hpp"
#include "campaign/forgery_checker.hpp"
#include "campaign/ground_truth.hpp"
#include "campaign/host_orders.hpp"
#include "campaign/invariants.hpp"
#include "campaign/overruns.hpp"
#include "campaign/processing_times.hpp"
#include "campaign/queue_checker.hpp"
#include "campaign/recovery_checker.hpp"
#include "campaign/route_checker.hpp"
#include "campaign/sample_ledger.hpp"
#include "campaign/sampling_checker.hpp"
#include "campaign/tag_checker.hpp"
#include "campaign/topology_checker.hpp"
#include "campaign/torque_ledger.hpp"
#include "campaign/touch_checker.hpp"
#include "robotskin/timing.h"
#include "world/network/network.hpp"

namespace robotskin::campaign {

// A port carries 66 cells at 250 Hz, 82.5 % of its frames of 50 us; fewer where jitter and slow clocks make them
// longer.
inline std::uint32_t cells_carried(const world::LineQuality& line) {
  const double frame_us = (RS_FRAME_US + line.jitter_us / 2) * (1 + 1e-6 * line.clock_drift_ppm);
  return static_cast<std::uint32_t>(RS_CELLS_PER_PORT * RS_FRAME_US / frame_us + 0.01);
}

// What a section unit may know, the frames a line of its own clock carries less beacons, status and torque sums; and
// what leaves a line as it is 5 % to empty queues with.
inline QueueChecker::PortLoad port_load(const world::LineQuality& line, std::int32_t limbs, ProcessingTimes times) {
  constexpr double line_hz = 1e6 / RS_FRAME_US, epoch_hz = 1e6 / (RS_EPOCH_TICKS * RS_TICK_US),
                   control = ControlMeter::share_max;
  constexpr double least_hz = 1e6 / RS_TICK_US + 1e6 / RS_STATUS_MEAN_US;
  const double worst_hz = 1e6 / ((RS_FRAME_US + line.jitter_us / 2) * (1 + 1e-6 * line.clock_drift_ppm));
  const auto cells = [limbs](double samples_hz) {
    return static_cast<std::uint32_t>((samples_hz - epoch_hz * limbs) / RS_CLOCK_RATE_DEFAULT_HZ);
  };
  // A status waits for its pause, a frame on the line, a beacon and the torque sums; the divisor goes down with a
  // tick. The processor takes its time for both.
  const std::int64_t known_hop_ns =
      (RS_STATUS_PAUSE_US + (2 + limbs) * RS_FRAME_US) * us + times.status_ns + idle_hop_ns + times.tick_ns;
  return {.bearable = cells(line_hz - least_hz),
          .draining = cells(worst_hz * (0.95 - control)),
          .sums = static_cast<std::uint32_t>(limbs),
          .known_hop_ns = known_hop_ns};
}

class Checkers : public world::Observer, public world::DatagramSink {
 public:
  // The network is not there yet: it needs the ledger for its readings.
  explicit Checkers(const FaultCase& drawn)
      : times_(drawn.options.processor),
        ledger_(drawn, breaks_),
        sampling_(drawn, breaks_),
        torques_(drawn.wiring.cell_count(), drawn.workload.limbs, times_, drawn.options.line, breaks_),
        touch_(drawn, breaks_),
        queues_(drawn.wiring.cell_count(), drawn.workload.events, breaks_),
        forgeries_(breaks_),
        tags_(drawn.options.cell_key, breaks_),
        orders_(drawn.workload, drawn.seed, drawn.options.line, breaks_),
        balance_(breaks_),
        topology_(drawn.wiring.cell_count(), drawn.options.line, breaks_),
        line_(drawn.options.line),
        loads_(drawn.wiring.cell_count(), cells_carried(line_),
               drawn.workload.events && drawn.workload.events_hz > RS_CLOCK_RATE_DEFAULT_HZ),
        port_load_(port_load(line_, drawn.workload.touch ? 1 : drawn.workload.limbs, times_)),
        overruns_(times_, drawn.workload.touch ? 1 : drawn.workload.limbs),
        whole_lines_(drawn.whole_lines) {}

  void watch(world::Network& network, const std::vector<world::Fault>& faults);
  void poll();    // every millisecond of virtual time
  void finish();  // at the end

  HostOrders& orders() { return orders_; }
  SampleLedger& ledger() { return ledger_; }
  const BreakLog& breaks() const { return breaks_; }
  const RecoveryChecker& recovery() const { return *recovery_; }
  const ControlMeter& control() const { return *control_; }
  const QueueChecker& queues() const { return queues_; }
  const RouteChecker& routes() const { return *routes_; }
  const TorqueLedger& torques() const { return torques_; }
  const TouchChecker& touch() const { return touch_; }
  const BalanceChecker& balance() const { return balance_; }
  const TopologyChecker& topology() const { return topology_; }
  const ForgeryChecker& forgeries() const { return forgeries_; }

  void send(std::size_t, std::int64_t, std::span<const std::uint8_t>) override {}

  void cell_stepped(const world::Network& network, std::size_t cell, const rs_input& input,
                    const rs_output& output) override;
  void frame_sent(const world::Network& network, world::WireEnd from, const std::uint8_t* frame) override;
  void frame_ended(const world::Network& network, world::WireEnd from, world::WireEnd to, const std::uint8_t* frame,
                   world::FrameFate fate) override;
  void frame_planted(const world::Network& network, world::WireEnd to, const std::uint8_t* frame,
                     const world::Fault& fault) override;
  void datagram_to_host(const world::Network& network, std::size_t unit, std::span<const std::uint8_t> bytes) override;
  void fault_applied(const world::Network& network, const world::Fault& fault, int phase) override;

 private:
  void weigh();

  const world::Network* network_ = nullptr;
  BreakLog breaks_;
  ProcessingTimes times_;
  SampleLedger ledger_;
  SamplingChecker sampling_;
  TorqueLedger torques_;
  TouchChecker touch_;
  QueueChecker queues_;
  ForgeryChecker forgeries_;
  TagChecker tags_;
  HostOrders orders_;
  BalanceChecker balance_;
  TopologyChecker topology_;
  std::optional<GroundTruth> ground_;
  std::optional<BeaconLog> beacons_;
  std::optional<RouteChecker> routes_;
  std::optional<RecoveryChecker> recovery_;
  std::optional<ControlMeter> control_;
  world::LineQuality line_;
  CableLoads loads_;
  QueueChecker::PortLoad port_load_;
  Overruns overruns_;
  bool whole_lines_;
  bool forged_comes_ = false;  // to the cell that steps next
};

}  // namespace robotskin::campaign
