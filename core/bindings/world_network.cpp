// SPDX-License-Identifier: Apache-2.0
// Binds the simulated network and what steps it with the body.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <stdexcept>

#include "bindings/bytes.hpp"
#include "bindings/contribution.hpp"
#include "bindings/world.hpp"
#include "world/network/in_process.hpp"
#include "world/network/udp_transport.hpp"
#include "world/world.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::bindings {
namespace {

using world::Body;
using world::InProcess;
using world::LineQuality;
using world::Network;
using world::NetworkCounts;
using world::NetworkOptions;
using world::Transport;
using world::UdpTransport;
using world::UnitDescription;
using world::Wiring;
using world::World;
using Neighbours = nb::ndarray<const std::int32_t, nb::shape<-1, 4, 2>, nb::c_contig, nb::device::cpu>;
using Bytes = nb::bytes;

// Checks what it takes.
Wiring wiring_of(const Neighbours& neighbours, const std::vector<std::uint16_t>& id,
                 std::vector<UnitDescription> units) {
  Wiring wiring;
  const auto cells = static_cast<std::int32_t>(neighbours.shape(0));
  if (id.size() != neighbours.shape(0)) throw std::invalid_argument("wiring: one id a cell");
  const auto check = [cells](std::int32_t cell, std::int32_t port) {
    if (cell < -1 || cell >= cells || (cell >= 0 && (port < 1 || port > RS_PORTS)))
      throw std::invalid_argument("wiring: neighbour " + std::to_string(cell) + " port " + std::to_string(port) +
                                  ": must be a cell below " + std::to_string(cells) + " and a port 1 to 4");
  };
  for (std::int32_t i = 0; i < cells; ++i) {
    std::array<world::CellEnd, 4> ends;
    for (int p = 0; p < RS_PORTS; ++p) {
      const std::int32_t cell = neighbours(i, p, 0), port = neighbours(i, p, 1);
      check(cell, port);
      ends[p] = {cell, static_cast<std::uint8_t>(port)};
    }
    wiring.neighbours.push_back(ends);
  }
  for (const UnitDescription& unit : units) {
    if (unit.ports.empty() || unit.ports.size() > RS_SECTION_UNIT_PORTS_MAX)
      throw std::invalid_argument("wiring: a section unit has 1 to 15 ports, not " + std::to_string(unit.ports.size()));
    for (const world::CellEnd& end : unit.ports) check(end.cell, end.port);
  }
  wiring.id = id;
  wiring.units = std::move(units);
  return wiring;
}

void bind_options(nb::module_& module) {
  nb::class_<LineQuality>(module, "LineQuality",
                          "How good wires and clocks are; the faults of a run come from its seed.")
      .def(nb::init<>())
      .def_rw("jitter_us", &LineQuality::jitter_us, "a frame takes up to this much longer than its 50 us")
      .def_rw("lost_share", &LineQuality::lost_share, "of frames, on each wire")
      .def_rw("bit_error_rate", &LineQuality::bit_error_rate, "before the checksum is seen")
      .def_rw("clock_drift_ppm", &LineQuality::clock_drift_ppm, "each cell's clock, within +-")
      .def_rw("power_up_spread_us", &LineQuality::power_up_spread_us, "cells start within this time")
      .def_rw("unit_skew_us", &LineQuality::unit_skew_us, "section units' clocks at the start, within +-")
      .def_rw("unit_drift_ppm", &LineQuality::unit_drift_ppm, "section units' clocks, within +-");

  nb::class_<Wiring>(module, "Wiring", "Which port is plugged into which.")
      .def(
          "__init__",
          [](Wiring* self, const Neighbours& neighbours, const std::vector<std::uint16_t>& id,
             const std::vector<UnitDescription>& units) { new (self) Wiring(wiring_of(neighbours, id, units)); },
          "neighbours"_a, "id"_a, "units"_a,
          "neighbours: (N, 4, 2) int32, for own port p at row p - 1 the neighbour's index or -1, and its port; "
          "id: (N) kept in the cells' flash, 0: named by the network.")
      .def("__len__", &Wiring::cell_count);

  nb::class_<UnitDescription>(module, "UnitDescription", "A section unit and the cells at its ports.")
      .def(
          "__init__",
          [](UnitDescription* self, std::uint16_t group, std::uint8_t unit,
             const std::vector<std::tuple<int, int>>& ports, std::int64_t skew_ns, double drift_ppm) {
            new (self) UnitDescription{group, unit, {}, skew_ns, drift_ppm};
            for (const auto& [cell, port] : ports) self->ports.push_back({cell, static_cast<std::uint8_t>(port)});
          },
          "group"_a, "unit"_a, "ports"_a, "skew_ns"_a = 0, "drift_ppm"_a = 0.0,
          "ports: (cell, cell port) of port p at index p - 1; skew and drift of its clock against virtual time.")
      .def_rw("skew_ns", &UnitDescription::skew_ns, "its clock less virtual time at the start")
      .def_rw("drift_ppm", &UnitDescription::drift_ppm, "of its clock")
      .def_ro("group", &UnitDescription::group, "of the section unit")
      .def_ro("unit", &UnitDescription::unit, "its number in the group");

  nb::enum_<world::Processor>(module, "Processor",
                              "Of the cells, at 48 MHz: what an input takes is as metered on the chip.")
      .value("none", world::Processor::none, "computes in no time")
      .value("zero_wait_states", world::Processor::zero_wait_states)
      .value("one_wait_state", world::Processor::one_wait_state, "for each word that is read from flash");

  module.def(
      "processing_ns",
      [](world::Processor processor, const std::string& kind, std::uint32_t frames) {
        const auto* const found = std::ranges::find(world::input_kind_names, std::string_view(kind));
        if (found == world::input_kind_names.end() || frames > RS_PORTS)
          throw std::invalid_argument("no input '" + kind + "' that starts " + std::to_string(frames) +
                                      " frames: one of INPUT_KINDS, 0 to 4");
        return world::processing_ns(processor, static_cast<world::InputKind>(found - world::input_kind_names.begin()),
                                    frames);
      },
      "processor"_a, "kind"_a, "frames"_a,
      "What an input of this kind (INPUT_KINDS) takes that starts so many frames.");

  nb::class_<NetworkOptions>(module, "NetworkOptions", "How a network is run.")
      .def(nb::init<>())
      .def_rw("processor", &NetworkOptions::processor, "of the cells")
      .def_rw("line", &NetworkOptions::line, "LineQuality")
      .def_rw("batch_us", &NetworkOptions::batch_us, "a frame waits at most this long for its datagram; 0: no other")
      .def_rw("unasked", &NetworkOptions::unasked, "section units send without a keep-alive")
      .def_rw("powered", &NetworkOptions::powered, "ports have power from the start")
      .def_rw(
          "threads", &NetworkOptions::threads,
          "that run groups of section units that share no wire side by side, the caller's among them; 0: all is one")
      .def_rw("epoch_ns", &NetworkOptions::epoch_ns, "the section units' clock at virtual time 0")
      .def_rw("seed", &NetworkOptions::seed, "of all that is drawn by chance")
      .def_rw("clock_rate_hz", &NetworkOptions::clock_rate_hz, "kept in the cells' flash: 0, 63, 125 or 250")
      .def_rw("faults", &NetworkOptions::faults, "that strike during the run")
      .def(
          "set_key", [](NetworkOptions& self, const nb::bytes& key) { self.key = key_from(key); }, "key"_a,
          "32 bytes that host and section units share: datagrams are authenticated in both directions.")
      .def(
          "set_cell_key",
          [](NetworkOptions& self, const nb::bytes& key) {
            if (key.size() != RS_CELL_KEY_BYTES)
              throw std::invalid_argument("a cell key has 16 bytes, not " + std::to_string(key.size()));
            self.cell_key.emplace();
            std::copy_n(bytes_of(key).data(), key.size(), self.cell_key->begin());
          },
          "key"_a, "16 bytes that section units and cells share: ticks and commands are authenticated.");
}

void bind_network(nb::module_& module) {
  nb::class_<NetworkCounts>(module, "NetworkCounts", "What has happened in a network since its start.")
      .def_ro("frames_sent", &NetworkCounts::frames_sent, "begun on a wire with something at its end")
      .def_ro("frames_delivered", &NetworkCounts::frames_delivered, "hops")
      .def_ro("frames_lost", &NetworkCounts::frames_lost, "on a wire: by chance, cut, or to a dead cell")
      .def_ro("frames_damaged", &NetworkCounts::frames_damaged, "by bit errors")
      .def_ro("frames_overrun", &NetworkCounts::frames_overrun, "of those: to a cell too busy to take them")
      .def_ro("cell_steps", &NetworkCounts::cell_steps, "inputs that cells have taken")
      .def_ro("events", &NetworkCounts::events, "of virtual time, all kinds")
      .def_ro("datagrams", &NetworkCounts::datagrams, "sent by section units")
      .def_ro("datagram_bytes", &NetworkCounts::datagram_bytes, "in those")
      .def_ro("records", &NetworkCounts::records, "frames inside datagrams");

  const auto check = [](const Network& self, std::size_t cell, int port = 1) {
    if (cell >= self.cell_count() || port < 1 || port > RS_PORTS)
      throw std::out_of_range("cell " + std::to_string(cell) + " port " + std::to_string(port) + ": there are " +
                              std::to_string(self.cell_count()) + " cells of 4 ports");
  };
  nb::class_<Network> network(module, "Network", "Cells, wires and section units in virtual time.");
  bind_world_survey(network);
  network.def_prop_ro("cell_count", &Network::cell_count, "N")
      .def_prop_ro("unit_count", &Network::unit_count, "section units")
      .def_prop_ro(
          "counts", [](const Network& self) { return self.counts(); }, "NetworkCounts so far")
      .def_prop_ro("frames_dropped", &Network::frames_dropped, "by full queues of cells and section units")
      .def_prop_ro("queue_peaks", &Network::queue_peaks, "(N) frames waiting in a cell at once, at most")
      .def_prop_ro("depths", &Network::depths, "(N) hops to the nearest powered port over wires that work, -1: none")
      .def_prop_ro("formed", &Network::formed, "every cell that can be reached has an id and its shortest path")
      .def_prop_ro("log_hash", &Network::log_hash, "of every frame and datagram so far")
      .def_prop_ro("lane_count", &Network::lane_count, "parts that share nothing, if they are run apart")
      .def(
          "alive",
          [check](const Network& self, std::size_t cell) {
            check(self, cell);
            return self.alive(cell);
          },
          "cell"_a, "Whether it has power and runs.")
      .def(
          "cell_id",
          [check](const Network& self, std::size_t cell) {
            check(self, cell);
            return self.cell(cell).id;
          },
          "cell"_a, "0: not named yet.")
      .def(
          "cell_hops",
          [check](const Network& self, std::size_t cell) {
            check(self, cell);
            return self.cell(cell).route.hops;
          },
          "cell"_a, "To its section unit, as it believes; 255: without a way.")
      .def(
          "cell_parent_port",
          [check](const Network& self, std::size_t cell) {
            check(self, cell);
            return self.cell(cell).route.parent_port;
          },
          "cell"_a, "1 to 4, 0: no parent.")
      .def(
          "contribute",
          [](Network& self, std::size_t cell, unsigned limb, const std::vector<std::int32_t>& torque, bool active,
             unsigned age) { self.contribute(cell, contribution_of(limb, torque, active, age)); },
          "cell"_a, "limb"_a, "torque"_a, "active"_a = false, "age"_a = 0,
          "What a cell adds to its limb's joints in each epoch, in the limb's step; up to 12 joints, none: nothing.")
      .def(
          "set_torque_image",
          [check](Network& self, std::size_t cell, const nb::bytes& image) {
            check(self, cell);
            if (image.size() != RS_TORQUE_IMAGE_BYTES)
              throw std::invalid_argument("an image of torque parameters has " + std::to_string(RS_TORQUE_IMAGE_BYTES) +
                                          " bytes, not " + std::to_string(image.size()));
            self.set_torque_image(cell, bytes_of(image).first<RS_TORQUE_IMAGE_BYTES>());
          },
          "cell"_a, "image"_a, "Torque parameters in a cell's flash, which it finds at its next start.")
      .def(
          "put",
          [check](Network& self, std::size_t cell, world::ExternalCell& external) {
            check(self, cell);
            self.put(cell, external);
          },
          "cell"_a, "external"_a, nb::keep_alive<1, 3>(), "From its boot on the external cell lives as this cell.")
      .def(
          "torque_epochs",
          [](const Network& self, std::size_t unit) {
            const rs_unit_torque& torque = self.unit(unit).torque;
            return nb::make_tuple(torque.complete, torque.incomplete, torque.late);
          },
          "unit"_a, "epochs handed over with all that was expected, and without; frames that came after that")
      .def(
          "rate_divisors",
          [](const Network& self, std::size_t unit) {
            std::vector<int> divisors;
            for (unsigned p = 0; p < self.unit(unit).config.ports; ++p)
              divisors.push_back(self.unit(unit).port[p].rate.divisor);
            return divisors;
          },
          "unit"_a, "of each port")
      .def(
          "cell_led",
          [check](const Network& self, std::size_t cell) {
            check(self, cell);
            return self.cell(cell).led_rgb;
          },
          "cell"_a, "0xRRGGBB of its light.")
      .def(
          "cut",
          [check](Network& self, std::size_t cell, int port, bool out, bool in) {
            check(self, cell, port);
            self.cut(cell, port, out, in);
          },
          "cell"_a, "port"_a, "out"_a = true, "in_"_a = true, "The wire at this port carries nothing any more.")
      .def(
          "mend",
          [check](Network& self, std::size_t cell, int port) {
            check(self, cell, port);
            self.mend(cell, port);
          },
          "cell"_a, "port"_a, "The wire at this port works again.")
      .def(
          "kill",
          [check](Network& self, std::size_t cell) {
            check(self, cell);
            self.kill(cell);
          },
          "cell"_a, "Takes a cell's power.")
      .def(
          "reboot",
          [check](Network& self, std::size_t cell, std::int64_t off_ns) {
            check(self, cell);
            self.reboot(cell, off_ns);
          },
          "cell"_a, "off_ns"_a = 0, "Starts a cell, after this time without power.")
      .def("inject", &Network::inject, "fault"_a,
           "Lets a fault strike at its time, which must not be over. Raises FaultError.");
}

}  // namespace

void bind_world_network(nb::module_& module) {
  bind_world_faults(module);
  bind_options(module);
  bind_world_external_cell(module);
  bind_network(module);
  bind_world_trial(module);
  nb::class_<Transport>(module, "Transport", "Carries datagrams between section units and host.");
  nb::class_<InProcess, Transport>(module, "InProcess", "In process: datagrams wait until they are taken.")
      .def(nb::init<>())
      .def_prop_ro("overflowed", &InProcess::overflowed,
                   "datagrams dropped, the oldest first, because they were not taken in time")
      .def(
          "post", [](InProcess& self, std::size_t unit, const Bytes& datagram) { self.post(unit, bytes_of(datagram)); },
          "unit"_a, "datagram"_a, "From the host to a section unit (its index).")
      .def(
          "take",
          [](InProcess& self) {
            nb::list letters;
            for (const InProcess::Waiting& letter : self.take())
              letters.append(
                  nb::make_tuple(letter.unit, letter.time_ns, Bytes(letter.datagram.data(), letter.datagram.size())));
            return letters;
          },
          "What the section units have sent: (unit index, virtual time in ns, datagram) in order.");

  nb::class_<UdpTransport, Transport>(
      module, "UdpTransport", "Real UDP, a socket for each section unit; each answers the host that last spoke to it.")
      .def(
          "__init__",
          [](UdpTransport* self, std::size_t units, const std::string& bind, std::uint16_t first_port,
             const std::optional<std::pair<std::string, std::uint16_t>>& host) {
            std::optional<driver::Address> address;
            if (host) address = driver::Address::resolve(host->first, host->second);
            new (self) UdpTransport(units, bind, first_port, address);
          },
          "units"_a, "bind"_a = "127.0.0.1", "first_port"_a = 0, "host"_a = nb::none(),
          "`host`: (host, port) to send to before any host has asked. Raises RuntimeError if a port is taken.")
      .def_prop_ro(
          "addresses",
          [](const UdpTransport& self) {
            std::vector<std::pair<std::string, std::uint16_t>> all;
            for (std::size_t u = 0; u < self.unit_count(); ++u)
              all.emplace_back(self.address(u).host(), self.address(u).port());
            return all;
          },
          "(host, port) of each section unit")
      .def_prop_ro("sent", &UdpTransport::sent, "datagrams handed to the system")
      .def_prop_ro("unsent", &UdpTransport::unsent, "datagrams without a host, or that the system did not take")
      .def_prop_ro("received", &UdpTransport::received, "datagrams from the host");

  nb::class_<World>(module, "World", "Body and network in step.")
      .def(
          "__init__",
          [](World* self, Body* body, const Neighbours& neighbours, const std::vector<std::uint16_t>& id,
             const std::vector<UnitDescription>& units, const NetworkOptions& options, Transport& transport,
             double step_s) { new (self) World(body, wiring_of(neighbours, id, units), options, transport, step_s); },
          nb::keep_alive<1, 2>(), nb::keep_alive<1, 7>(), "body"_a.none(), "neighbours"_a, "id"_a, "units"_a,
          "options"_a, "transport"_a, "step_s"_a = 0.001)
      .def("run", &World::run, nb::call_guard<nb::gil_scoped_release>(), "duration_ns"_a,
           "So much virtual time passes.")
      .def_prop_ro("time_ns", &World::time_ns, "virtual time")
      .def_prop_ro("body_took_ns", &World::body_took_ns, "real time of the body's steps so far")
      .def_prop_ro("network_took_ns", &World::network_took_ns, "real time of the network so far")
      .def_prop_ro("formed_ns", &World::formed_ns, "virtual time when the network first was whole, -1: not yet")
      .def_prop_ro("network", nb::overload_cast<>(&World::network), nb::rv_policy::reference_internal, "the Network");
}

}  // namespace robotskin::bindings
