// SPDX-License-Identifier: Apache-2.0
// Binds measured runs of the network.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/vector.h>

#include "bindings/world.hpp"
#include "world/network/trial.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::bindings {

using world::FaultOutcome;
using world::NetworkOptions;
using world::NetworkTrial;
using world::TrialReport;
using world::Wiring;

void bind_world_trial(nb::module_& module) {
  nb::class_<FaultOutcome>(module, "FaultOutcome",
                           "What a fault did, until the next one struck. Cells that did not run, or were out of reach, "
                           "at some time since it struck count for `rejoin_ms` and `healed` only.")
      .def_ro("fault", &FaultOutcome::fault, "the Fault")
      .def_ro("recovery_ms", &FaultOutcome::recovery_ms, "until every cell in reach had a way again, for good")
      .def_ro("outage_ms", &FaultOutcome::outage_ms, "longest time during which a cell had none")
      .def_ro("rejoin_ms", &FaultOutcome::rejoin_ms, "until every cell in reach had one, restarted ones too")
      .def_ro("cells_cut_off", &FaultOutcome::cells_cut_off, "cells without a way at once, at most")
      .def_ro("healed", &FaultOutcome::healed, "every cell in reach had a way at the end");

  nb::class_<TrialReport>(module, "TrialReport", "How a network formed, healed and served the host in one run.")
      .def_ro("seconds", &TrialReport::seconds, "of virtual time")
      .def_ro("formation_ms", &TrialReport::formation_ms, "until every cell first had its shortest way; -1: never")
      .def_ro("named_ms", &TrialReport::named_ms, "and an id")
      .def_ro("outcomes", &TrialReport::outcomes, "by fault, in the order they struck")
      .def_ro("recovery_max_ms", &TrialReport::recovery_max_ms, "longest `recovery_ms` of all faults")
      .def_ro("whole", &TrialReport::whole, "every cell in reach has a way at the end")
      .def_ro("depth_max", &TrialReport::depth_max, "hops at the end, the cable counted")
      .def_ro("extra_depth_mean", &TrialReport::extra_depth_mean, "hops over the fewest possible")
      .def_ro("extra_depth_max", &TrialReport::extra_depth_max, "of the deepest such cell")
      .def_ro("port_loads", &TrialReport::port_loads, "cells that report through each port, by unit")
      .def_ro("cells_in_reach", &TrialReport::cells_in_reach, "at the end")
      .def_ro("samples_sent", &TrialReport::samples_sent, "since every cell had an id")
      .def_ro("samples_heard", &TrialReport::samples_heard, "of these by the host, each counted once")
      .def_ro("samples_lost", &TrialReport::samples_lost, "sent and never heard")
      .def_ro("samples_twice", &TrialReport::samples_twice, "duplicates that left the section units")
      .def_ro("host_gap_ms", &TrialReport::host_gap_ms,
              "longest silence at the host of a cell that ran and was in reach all the time")
      .def_ro("cell_gap_ms", &TrialReport::cell_gap_ms, "(N) longest silence of every cell; -1: never heard")
      .def_ro("steady", &TrialReport::steady, "(N) 1 if it ran and was in reach all the time")
      .def_ro("latency_mean_ms", &TrialReport::latency_mean_ms, "from sampling to the section unit's port")
      .def_ro("latency_p99_ms", &TrialReport::latency_p99_ms, "that 99 % of the samples keep")
      .def_ro("latency_max_ms", &TrialReport::latency_max_ms, "of the slowest sample")
      .def_ro("latency_counts", &TrialReport::latency_counts,
              "samples by that latency, 10 us each; beyond the last one in it")
      .def_ro("frames_lost", &TrialReport::frames_lost, "on wires")
      .def_ro("frames_dropped", &TrialReport::frames_dropped, "by full queues")
      .def_ro("queue_peak", &TrialReport::queue_peak, "frames waiting in a cell at once, at most")
      .def_ro("counts", &TrialReport::counts, "NetworkCounts")
      .def_ro("log_hash", &TrialReport::log_hash, "of every frame and datagram");

  nb::class_<NetworkTrial>(module, "NetworkTrial",
                           "A network without a body, run with its faults and measured; the cells lie still.")
      .def(nb::init<const Wiring&, NetworkOptions>(), "wiring"_a, "options"_a, "Raises FaultError.")
      .def(
          "run_until",
          [](NetworkTrial& self, double time_s) { self.run_until(static_cast<std::int64_t>(1e9 * time_s)); },
          nb::call_guard<nb::gil_scoped_release>(), "time_s"_a, "Up to this virtual time.")
      .def("measure_anew", &NetworkTrial::measure_anew, "Samples, gaps and latencies count from now on.")
      .def("report", &NetworkTrial::report, "All that was measured so far.")
      .def_prop_ro(
          "time_s", [](const NetworkTrial& self) { return 1e-9 * static_cast<double>(self.network().time_ns()); },
          "s, virtual")
      .def_prop_ro("network", nb::overload_cast<>(&NetworkTrial::network), nb::rv_policy::reference_internal,
                   "the Network");
}

}  // namespace robotskin::bindings
