// SPDX-License-Identifier: Apache-2.0
// Binds the traffic of section units without cells: load for the driver's benchmark and tests.
#include "traffic/traffic.hpp"

#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings/bytes.hpp"
#include "bindings/lab.hpp"

namespace robotskin::bindings {
namespace {

namespace nb = nanobind;
using namespace nb::literals;
using namespace lab;

TrafficOptions options_from(std::size_t cells, unsigned rate_hz, const std::optional<nb::bytes>& key, unsigned records,
                            std::uint64_t seed, bool event_mode) {
  TrafficOptions options;
  options.cells = cells;
  options.rate_hz = rate_hz;
  options.records_per_datagram = records;
  options.seed = seed;
  options.event_mode = event_mode;
  if (key) options.key = key_from(*key);
  return options;
}

}  // namespace

void bind_traffic(nb::module_ module) {
  nb::class_<Traffic>(module, "Traffic",
                      "The datagrams of section units with many cells in clock mode, without simulating cells.")
      .def(
          "__init__",
          [](Traffic* self, std::size_t cells, unsigned rate_hz, const std::optional<nb::bytes>& key, unsigned records,
             std::uint64_t seed,
             bool event_mode) { new (self) Traffic(options_from(cells, rate_hz, key, records, seed, event_mode)); },
          "cells"_a = 1260, nb::kw_only(), "rate_hz"_a = 250, "key"_a = nb::none(),
          "records_per_datagram"_a = int{RS_DATAGRAM_RECORDS_MAX}, "seed"_a = 1, "event_mode"_a = false)
      .def("keys", &Traffic::keys)
      .def("hear", [](Traffic& self, const nb::bytes& datagram) { self.hear(bytes_of(datagram)); })
      .def_prop_ro("frames", &Traffic::frames, "Frames sent so far.")
      .def_prop_ro("connected", &Traffic::connected, "Whether every unit has a host and knows that it lives now.")
      .def(
          "step",
          [](Traffic& self, std::uint64_t now_ns) {
            nb::list list;
            self.step(now_ns, [&](std::span<const std::uint8_t> datagram) {
              list.append(nb::bytes(reinterpret_cast<const char*>(datagram.data()), datagram.size()));
            });
            return list;
          },
          "now_ns"_a, nb::sig("def step(self, now_ns: int) -> list[bytes]"),
          "The datagrams of the millisecond that ends at `now_ns` of the section units' clock.")
      .def(
          "flush",
          [](Traffic& self, std::uint64_t now_ns) {
            nb::list list;
            self.flush(now_ns, [&](std::span<const std::uint8_t> datagram) {
              list.append(nb::bytes(reinterpret_cast<const char*>(datagram.data()), datagram.size()));
            });
            return list;
          },
          "now_ns"_a, nb::sig("def flush(self, now_ns: int) -> list[bytes]"),
          "The datagrams of what still waits for its datagram to fill.")
      .def(
          "sent",
          [](const Traffic& self) {
            const std::vector<driver::Sample>& rows = self.sent();
            nb::dict dict;
            const auto column = [&]<class Value>(const char* name, std::size_t columns, Value, const auto& value) {
              dict[name] =
                  filled<Value>(rows.size(), columns, [&](std::size_t i, std::size_t c) { return value(rows[i], c); });
            };
            using driver::Sample;
#define ROBOTSKIN_COLUMN(name, is_signed, first, channels, ...) \
  column(#name, channels, driver::Counts<(is_signed) != 0>{}, [](const Sample& s, std::size_t c) { return s.name[c]; });
            RS_SENSORS(ROBOTSKIN_COLUMN)
#undef ROBOTSKIN_COLUMN
            column("sequence", 1, std::uint8_t{}, [](const Sample& s, std::size_t) { return s.sequence; });
            column("seen", 1, bool{}, [](const Sample& s, std::size_t) -> bool { return s.seen; });
            return dict;
          },
          nb::sig("def sent(self) -> dict[str, numpy.ndarray]"),
          "The last frame of each cell, sent or waiting, in counts.");
  module.def(
      "send_traffic",
      [](const std::pair<std::string, std::uint16_t>& to, const std::pair<std::string, std::uint16_t>& local,
         double seconds, std::size_t cells, unsigned rate_hz, const std::optional<nb::bytes>& key, unsigned records,
         std::uint64_t seed, double patience_s, bool realtime, bool prepared) {
        const TrafficOptions options = options_from(cells, rate_hz, key, records, seed, false);
        TrafficReport report;
        {
          nb::gil_scoped_release release;
          report = send_traffic(options, to.first, to.second, local.first, local.second, seconds, patience_s, realtime,
                                prepared);
        }
        nb::dict dict;
        dict["frames"] = report.frames;
        dict["datagrams"] = report.datagrams;
        dict["seconds"] = report.seconds;
        dict["late_ms_max"] = report.late_ms_max;
        dict["cpu_seconds"] = report.cpu_seconds;
        dict["refused"] = report.refused;
        return dict;
      },
      "to"_a, "local"_a, "seconds"_a, nb::kw_only(), "cells"_a = 1260, "rate_hz"_a = 250, "key"_a = nb::none(),
      "records_per_datagram"_a = int{RS_DATAGRAM_RECORDS_MAX}, "seed"_a = 1, "patience_s"_a = 10.0,
      "realtime"_a = false, "prepared"_a = false,
      nb::sig("def send_traffic(to: tuple[str, int], local: tuple[str, int], seconds: float, *, cells: int = 1260, "
              "rate_hz: int = 250, key: bytes | None = None, records_per_datagram: int = 69, seed: int = 1, "
              "patience_s: float = 10.0, realtime: bool = False, prepared: bool = False) -> dict[str, float]"),
      R"(Sends traffic over UDP in steps of a millisecond, as soon as a host listens; what was sent.
`prepared`: all of it is made and tagged before the first datagram leaves.
Raises RuntimeError if no host sends a keep-alive within `patience_s`.)");
}

}  // namespace robotskin::bindings
