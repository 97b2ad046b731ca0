// SPDX-License-Identifier: Apache-2.0
// Binds section unit and cells on serial lines.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>

#include "bindings/bindings.hpp"
#include "bindings/bytes.hpp"
#include "serial/cell_runner.hpp"
#include "serial/commissioner.hpp"
#include "serial/pseudo_terminal.hpp"
#include "serial/serial_error.hpp"
#include "serial/serial_line.hpp"
#include "serial/unit_daemon.hpp"
#include "serial/virtual_skin.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::bindings {
namespace {

using namespace serial;
using HostPort = std::pair<std::string, std::uint16_t>;
using Counts = nb::ndarray<const std::int32_t, nb::shape<-1, RS_CHANNEL_COUNT>, nb::c_contig, nb::device::cpu>;

std::optional<CellKey> cell_key_from(const std::optional<nb::bytes>& bytes) {
  if (!bytes) return std::nullopt;
  CellKey key;
  if (bytes->size() != key.size()) throw std::invalid_argument("cell_key: 16 bytes");
  std::copy_n(bytes_of(*bytes).data(), key.size(), key.begin());
  return key;
}

CellKeys cell_keys_from(const nb::bytes& bytes) {
  CellKeys keys;
  if (bytes.size() != keys.size()) throw std::invalid_argument("keys of a cell: 32 bytes");
  std::copy_n(bytes_of(bytes).data(), keys.size(), keys.begin());
  return keys;
}

UnitOptions options_of(std::uint16_t group, std::uint8_t unit, std::uint8_t units, std::uint32_t session,
                       const std::optional<nb::bytes>& key, const std::optional<nb::bytes>& cell_key, bool unasked) {
  if (session == 0 || units < 1 || units > RS_UNITS_MAX || unit >= units)
    throw std::invalid_argument("section unit: session from 1, at most 16 units in a group, `unit` below `units`");
  UnitOptions options{.group = group, .unit = unit, .units = units, .session = session, .unasked = unasked};
  if (key) options.key = key_from(*key);
  options.cell_key = cell_key_from(cell_key);
  return options;
}

nb::list told(const std::vector<LineCounts>& lines) {
  nb::list found;
  for (const LineCounts& line : lines) {
    nb::dict one;
    one["frames_in"] = line.frames_in;
    one["frames_out"] = line.frames_out;
    one["damaged"] = line.damaged;
    one["unsent"] = line.unsent;
    one["pulled"] = line.pulled;
    found.append(one);
  }
  return found;
}

void tell(nb::dict& report, const Stalls& stalls) {
  report["stalls"] = stalls.count;
  report["worst_stall_s"] = static_cast<double>(stalls.worst_ns) * 1e-9;
  report["realtime"] = stalls.realtime;
}

// Named: a line of another program's, and one that this program makes.
std::vector<std::unique_ptr<Line>> lines_of(const std::vector<std::pair<std::string, bool>>& named) {
  std::vector<std::unique_ptr<Line>> lines;
  for (const auto& [path, made] : named) {
    if (made)
      lines.push_back(std::make_unique<PseudoTerminal>(path));
    else
      lines.push_back(std::make_unique<SerialLine>(path));
  }
  return lines;
}

template <typename Runner>
void bind_running(nb::class_<Runner>& runner) {
  runner
      .def(
          "start", [](Runner& self, bool realtime) { self.start(realtime); }, "realtime"_a = true,
          "Runs on a thread of its own. `realtime`: before all that are not, where the system permits it.")
      .def(
          "stop",
          [](Runner& self) {
            const nb::gil_scoped_release unlocked;
            self.stop();
          },
          "Ends the thread.")
      .def("forget_stalls", [](Runner& self) { self.forget_stalls(); }, "Counts stalls anew.");
}

void bind_sensors(nb::module_& module) {
  nb::class_<CellSensors>(module, "CellSensors", "Where host-built cells get their readings.");
  nb::class_<SetSensors, CellSensors>(module, "SetSensors", "Readings that a program sets; a cell without is faulty.")
      .def(nb::init<std::size_t>(), "cells"_a)
      .def(
          "set",
          [](SetSensors& self, Counts counts, const std::vector<std::size_t>& faulty) {
            if (counts.shape(0) != self.cell_count()) throw std::invalid_argument("SetSensors: a row a cell");
            for (std::size_t cell = 0; cell < counts.shape(0); ++cell) {
              const bool fault = std::ranges::find(faulty, cell) != faulty.end();
              self.set(cell,
                       std::span<const std::int32_t, RS_CHANNEL_COUNT>(counts.data() + RS_CHANNEL_COUNT * cell,
                                                                       RS_CHANNEL_COUNT),
                       fault);
            }
          },
          "counts"_a, "faulty"_a = std::vector<std::size_t>{},
          "counts: (N, 9) int32, the channels of every cell; faulty: cells whose sensor is missing or at its end.");
  nb::class_<LibrarySensors, CellSensors>(
      module, "LibrarySensors",
      "A shared library with the C function `bool rs_board_sense(rs_sample*)` of a chip's board (board.h).")
      .def(nb::init<const std::string&>(), "path"_a, "Raises SerialError for what has no such function.");
}

void bind_unit(nb::module_& module) {
  nb::class_<UnitDaemon> daemon(module, "UnitDaemon",
                                "A section unit between serial lines of this machine and a UDP socket, in real time.");
  daemon.def(
      "__init__",
      [](UnitDaemon* self, const std::vector<std::string>& lines, const std::string& host, std::uint16_t port,
         const std::optional<nb::bytes>& key, const std::optional<nb::bytes>& cell_key, std::uint32_t session,
         std::uint16_t group, std::uint8_t unit, const std::vector<HostPort>& peers, const std::string& sysfs) {
        if (lines.empty() || lines.size() > RS_SECTION_UNIT_PORTS_MAX)
          throw std::invalid_argument("section unit: 1 to 15 lines");
        with_input_errors([&] {
          std::vector<driver::Address> others;
          for (const auto& [name, at] : peers) others.push_back(driver::Address::resolve(name, at));
          const auto units = static_cast<std::uint8_t>(std::max<std::size_t>(peers.size() + 1, unit + 1U));
          new (self) UnitDaemon(options_of(group, unit, units, session, key, cell_key, false), lines, host, port,
                                others, sysfs);
        });
      },
      "lines"_a, "host"_a = "127.0.0.1", "port"_a = 0, nb::kw_only(), "key"_a, "cell_key"_a, "session"_a, "group"_a = 1,
      "unit"_a = 0, "peers"_a = std::vector<HostPort>{}, "sysfs"_a = "/sys",
      R"(lines: paths; line k is port k + 1. host, port: where it answers; 0 for any free port. key: 32 bytes shared with
the host, cell_key: 16 bytes from which the cells' keys come; None: nothing is authenticated. session: drawn at each
start, never 0. group, unit: its place; peers: (host, port) of the group's other units. sysfs: where the system tells of
its devices. Raises SerialError: a line that is not there, takes no 4 Mb/s, or holds bytes back for more than 2 ms;
InputError: an address that cannot be bound.)");
  bind_running(daemon);
  daemon
      .def_prop_ro(
          "address",
          [](const UnitDaemon& self) {
            const driver::Address at = self.address();
            return HostPort{at.host(), at.port()};
          },
          "(host, port) where it answers")
      .def(
          "report",
          [](const UnitDaemon& self) {
            const UnitReport report = self.report();
            nb::dict found;
            found["lines"] = told(report.lines);
            found["datagrams_out"] = report.datagrams_out;
            found["datagrams_in"] = report.datagrams_in;
            found["unheard"] = report.unheard;
            found["other_versions"] = report.other_versions;
            found["refused"] = report.refused;
            found["named"] = report.named;
            tell(found, report.stalls);
            return found;
          },
          nb::sig("def report(self) -> dict[str, typing.Any]"),
          "Counts so far: of each line, of datagrams, cells named, and of stalls of more than 3 ms.");
}

void bind_cells(nb::module_& module) {
  nb::class_<HostCell>(module, "HostCell", "A host-built cell, and what is at its four ports.")
      .def(
          "__init__",
          [](HostCell* self, std::uint32_t uid, const std::vector<std::tuple<int, int, int>>& ends, std::uint16_t id,
             std::uint32_t random, const std::optional<nb::bytes>& keys, bool factory) {
            if (ends.size() != RS_PORTS || uid == 0) throw std::invalid_argument("HostCell: four ends, a uid from 1");
            new (self) HostCell{.uid = uid, .id = id, .random = random, .ends = {}, .factory = factory};
            if (keys) self->keys = cell_keys_from(*keys);
            for (std::size_t p = 0; p < RS_PORTS; ++p)
              self->ends[p] = {std::get<0>(ends[p]), static_cast<std::uint8_t>(std::get<1>(ends[p])),
                               std::get<2>(ends[p])};
          },
          "uid"_a, "ends"_a, "id"_a = 0, "random"_a = 1, nb::kw_only(), "keys"_a = nb::none(), "factory"_a = false,
          "uid: serial number. ends: (cell, its port 1 to 4, line) by own port; -1 for none. id: kept in its flash, 0: "
          "named by the section unit. random: another one at each start. keys: 32 bytes, its own in place of those "
          "from the skin's secret; factory: it has none yet, and waits for them at a line.");
  nb::class_<CellRunner> runner(module, "CellRunner", "Host-built cells on serial lines, in real time.");
  runner.def(
      "__init__",
      [](CellRunner* self, const std::vector<HostCell>& cells, const std::optional<nb::bytes>& key,
         CellSensors& sensors, const std::vector<std::pair<std::string, bool>>& lines) {
        new (self) CellRunner(cells, cell_key_from(key), sensors, lines_of(lines));
      },
      "cells"_a, "cell_key"_a.none(), "sensors"_a, "lines"_a, nb::keep_alive<1, 4>(),
      "lines: (path, made) by the numbers of the cells' ends; made: a pseudo-terminal that others find at the path. "
      "Raises SerialError.");
  bind_running(runner);
  runner.def("pull", &CellRunner::pull, "line"_a, "pulled"_a, "A line that is pulled carries nothing either way.")
      .def(
          "given_keys",
          [](const CellRunner& self, std::size_t cell) -> std::optional<nb::bytes> {
            const std::optional<CellKeys> keys = self.given_keys(cell);
            if (!keys) return std::nullopt;
            return nb::bytes(reinterpret_cast<const char*>(keys->data()), keys->size());
          },
          "cell"_a, "The keys that a cell has of its own, or that one without any was given; None: none yet.")
      .def("note_kept", &CellRunner::note_kept, "cell"_a,
           "Its given keys are stored for good: the cell may say so, and runs.")
      .def(
          "report",
          [](const CellRunner& self) {
            const CellsReport report = self.report();
            nb::dict found;
            found["lines"] = told(report.lines);
            found["samples"] = report.samples;
            found["with_parent"] = report.with_parent;
            found["links_lost"] = report.links_lost;
            tell(found, report.stalls);
            return found;
          },
          nb::sig("def report(self) -> dict[str, typing.Any]"),
          "Counts so far: of each line, samples taken, cells with a way to a section unit, "
          "times that one lost it, stalls of more than 3 ms.");
}

void bind_virtual(nb::module_& module) {
  nb::class_<VirtualSkin>(module, "VirtualSkin",
                          "Section unit and host-built cells with lines between, in virtual time.")
      .def(
          "__init__",
          [](VirtualSkin* self, const std::vector<HostCell>& cells, CellSensors& sensors, std::uint8_t lines,
             const std::optional<nb::bytes>& key, const std::optional<nb::bytes>& cell_key, std::int64_t epoch_ns,
             nb::callable take) {
            UnitOptions options = options_of(1, 0, 1, 1, key, cell_key, false);
            options.ports = lines;
            new (self) VirtualSkin(
                options, cells, sensors, epoch_ns, [take](std::span<const std::uint8_t> datagram, std::int64_t now_ns) {
                  take(nb::bytes(reinterpret_cast<const char*>(datagram.data()), datagram.size()), now_ns);
                });
          },
          "cells"_a, "sensors"_a, "lines"_a, "key"_a.none(), "cell_key"_a.none(), "epoch_ns"_a, "take"_a,
          nb::keep_alive<1, 3>(), "take(datagram, now_ns) gets what is for the host.")
      .def("run_until", &VirtualSkin::run_until, "now_ns"_a, "Lets virtual time pass.")
      .def(
          "receive", [](VirtualSkin& self, const nb::bytes& datagram) { self.receive(bytes_of(datagram)); },
          "datagram"_a, "From the host.")
      .def("pull", &VirtualSkin::pull, "line"_a, "pulled"_a, "A line that is pulled carries nothing.")
      .def_prop_ro(
          "samples", [](const VirtualSkin& self) { return self.cells().samples(); }, "taken by all cells so far");
}

}  // namespace

void bind_serial(nb::module_ module) {
  error_class<SerialError>(module, "SerialError", "A serial line that is not there, or is not fit for cells.");
  module.attr("LONGEST_LATENCY_MS") = longest_latency_ms;
  module.def("check_latency_timer", &check_latency_timer, "path"_a, "sysfs"_a = "/sys",
             "Raises SerialError for an adapter that holds bytes back for more than 2 ms.");
  module.def(
      "commission",
      [](const std::string& path, const nb::bytes& cell_key, std::optional<std::uint32_t> uid, double within_s) {
        const std::optional<CellKey> secret = cell_key_from(cell_key);
        const nb::gil_scoped_release unlocked;
        return commission(path, *secret, uid, std::chrono::milliseconds(static_cast<std::int64_t>(1000 * within_s)));
      },
      "path"_a, "cell_key"_a, "uid"_a = nb::none(), "within_s"_a = 3.0,
      "Writes the keys of the cell that is alone at a line and has none; its serial number. uid: the one expected. "
      "Raises SerialError: no cell, one that has keys, another one, firmware of another version, or no answer.");
  bind_sensors(module);
  bind_unit(module);
  bind_cells(module);
  bind_virtual(module);
}

}  // namespace robotskin::bindings
