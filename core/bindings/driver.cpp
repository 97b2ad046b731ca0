// SPDX-License-Identifier: Apache-2.0
// Binds the driver stage.
#include "bindings/driver.hpp"

#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <limits>
#include <random>

#include "bindings/bindings.hpp"
#include "bindings/bytes.hpp"
#include "bindings/driver_tables.hpp"
#include "driver/clock.hpp"

namespace robotskin::bindings {
namespace {

namespace nb = nanobind;
using namespace nb::literals;
using namespace driver;

using HostPort = std::pair<std::string, std::uint16_t>;

// Raises robotskin.errors.UnknownNameError.
std::uint8_t operation_from(const std::string& name) {
  nb::list choices;
#define ROBOTSKIN_OPERATION(operation, number, index, value) \
  if (name == #operation) return number;                     \
  choices.append(#operation);
  RS_OPERATIONS(ROBOTSKIN_OPERATION)
#undef ROBOTSKIN_OPERATION
  const nb::object type = nb::module_::import_("robotskin.errors").attr("UnknownNameError");
  PyErr_SetObject(type.ptr(), type("operation", name, choices).ptr());
  throw nb::python_error();
}

std::vector<CellKey> keys_from(const nb::object& model_or_keys) {
  const nb::object keys = nb::hasattr(model_or_keys, "key") ? nb::object(model_or_keys.attr("key")) : model_or_keys;
  std::vector<CellKey> out;
  for (const nb::handle key : keys) out.push_back(nb::cast<CellKey>(nb::int_(nb::borrow(key))));
  return out;
}

}  // namespace

HostDriver::HostDriver(const Options& options, const std::optional<Address>& local, ReceiverOptions receiver_options)
    : driver(options) {
  if (local) receiver = std::make_unique<Receiver>(driver, *local, std::move(receiver_options));
}

Receiver& HostDriver::socket() {
  if (!receiver) throw std::logic_error("the driver has no socket: give `bind` when it is made");
  return *receiver;
}

void HostDriver::demand_no_thread(const char* what) const {
  if (receiver && receiver->running()) {
    throw std::logic_error(std::string(what) + " while the driver's thread runs: stop() it first");
  }
}

void bind_driver(nb::module_ module) {
  nb::enum_<Verdict>(module, "Verdict", "What became of a datagram.")
#define ROBOTSKIN_VALUE(name, meaning) .value(#name, Verdict::name, meaning)
      ROBOTSKIN_DATAGRAM_VERDICTS(ROBOTSKIN_VALUE)
#undef ROBOTSKIN_VALUE
          ;

  module.def(
      "keyed_tag",
      [](const nb::bytes& key, const nb::bytes& bytes) {
        const Tag tag = KeyedHash(key_from(key)).tag(bytes_of(bytes));
        return nb::bytes(reinterpret_cast<const char*>(tag.data()), tag.size());
      },
      "key"_a, "bytes"_a,
      "The tag of a datagram: the first 16 bytes of BLAKE2s-256 (RFC 7693) with a key of 32 bytes.");
  module.def("monotonic_ns", &monotonic_ns, "The host clock: CLOCK_MONOTONIC in nanoseconds.");

  nb::class_<HostDriver>(module, "Driver",
                         R"(Datagrams of section units in, the newest checked sample of every cell out.

In process, give datagrams to `handle` and call `publish`; with a socket, call `poll`, or `start` a thread.)")
      .def(
          "__init__",
          [](HostDriver* self, const nb::object& cells, const std::optional<nb::bytes>& key,
             const std::optional<HostPort>& bind, const std::vector<HostPort>& units, std::optional<std::uint64_t> seed,
             std::size_t spare_cells, std::size_t spare_groups, double batch_ms, bool realtime) {
            with_input_errors([&] {
              Options options{.keys = keys_from(cells),
                              .key = {},
                              .session_seed = 0,
                              .spare_cells = spare_cells,
                              .spare_groups = spare_groups};
              if (key) options.key = key_from(*key);
              std::random_device random;
              options.session_seed = seed ? *seed : std::uint64_t{random()} << 32 | random();
              std::optional<Address> local;
              ReceiverOptions receiver;
              receiver.realtime = realtime;
              receiver.batch_ns = static_cast<std::int64_t>(batch_ms * 1e6);
              if (bind) {
                options.calendar_ns = calendar_ns();
                local = Address::resolve(bind->first, bind->second);
                for (const HostPort& unit : units) {
                  receiver.units.push_back(Address::resolve(unit.first, unit.second, local->storage.ss_family));
                }
              }
              new (self) HostDriver(options, local, std::move(receiver));
            });
          },
          "cells"_a, "key"_a = nb::none(), "bind"_a = nb::none(), "units"_a = std::vector<HostPort>{}, nb::kw_only(),
          "session_seed"_a = nb::none(), "spare_cells"_a = 0, "spare_groups"_a = 0, "batch_ms"_a = 0.8,
          "realtime"_a = false,
          R"(`cells`: a SkinModel, or cell keys (section unit << 16 | id), whose order is that of every array.
`key`: 32 bytes shared with the section units; with it nothing unauthenticated is accepted.
`bind`: (host, port) of a UDP socket, port 0 for any free one. `units`: (host, port) of section units to wake.
`session_seed`: sessions are drawn from it, by default at random. `spare_cells`, `spare_groups`: room for cells and
section-unit groups not in `cells`, added when first heard. `batch_ms`: pause between two wakes of the thread.
`realtime`: the thread runs before all that are not real-time, where the system permits it.
Raises InputError for a bad key or cell, a host that is not known and an address that cannot be bound.)")
      .def(
          "handle",
          [](HostDriver& self, const nb::bytes& datagram, std::int64_t now_ns) {
            self.demand_no_thread("handle");
            return self.driver.handle(bytes_of(datagram), now_ns);
          },
          "datagram"_a, "now_ns"_a, "Takes one datagram that arrived at host time `now_ns`; what became of it.")
      .def(
          "publish",
          [](HostDriver& self, std::int64_t now_ns) {
            self.demand_no_thread("publish");
            self.driver.publish(now_ns);
          },
          "now_ns"_a, "Hands everything taken so far to readers.")
      .def(
          "downlink",
          [](HostDriver& self, std::int64_t now_ns) {
            self.demand_no_thread("downlink");
            nb::list list;
            self.driver.downlink(now_ns, [&](const Recipient& to, std::span<const std::uint8_t> bytes) {
              list.append(nb::make_tuple(to.group, to.unit,
                                         nb::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size())));
            });
            return list;
          },
          "now_ns"_a, nb::sig("def downlink(self, now_ns: int) -> list[tuple[int, int, bytes]]"),
          "The datagrams due to section units now: (section unit group, unit, bytes); unit 255: all of the group.")
      .def(
          "poll",
          [](HostDriver& self, std::optional<std::int64_t> now_ns) {
            self.demand_no_thread("poll");
            nb::gil_scoped_release release;
            return self.socket().poll(now_ns);
          },
          "now_ns"_a = nb::none(),
          "Takes and publishes all that has arrived at the socket and sends what is due; datagrams taken.\n\n"
          "`now_ns`: the time it is, for a world in virtual time; by default the host's clock.")
      .def(
          "start", [](HostDriver& self) { self.socket().start(); }, "Starts the receiving thread.")
      .def(
          "stop",
          [](HostDriver& self) {
            nb::gil_scoped_release release;
            self.socket().stop();
          },
          "Stops the receiving thread.")
      .def_prop_ro(
          "running", [](const HostDriver& self) { return self.receiver && self.receiver->running(); },
          "Whether the receiving thread runs.")
      .def_prop_ro(
          "address",
          [](HostDriver& self) {
            const Address local = self.socket().socket().local();
            return HostPort{local.host(), local.port()};
          },
          "(host, port) of the socket.")
      .def_prop_ro(
          "session", [](const HostDriver& self) { return self.driver.session(); }, "This driver's present session.")
      .def(
          "command",
          [](HostDriver& self, const std::string& operation, std::int64_t value, std::uint16_t index,
             std::optional<CellKey> cell, std::uint16_t group) {
            return with_input_errors([&] {
              Command command;
              command.operation = operation_from(operation);
              const bool wide = command.operation == RS_OPERATION_torque_word;
              if (value < (wide ? 0 : std::numeric_limits<std::int32_t>::min()) ||
                  value > (wide ? std::int64_t{0xFFFFFFFFFFFF} : std::numeric_limits<std::uint32_t>::max())) {
                throw std::invalid_argument("value " + std::to_string(value) + " does not fit into " +
                                            (wide ? "48" : "32") + " bits");
              }
              command.value = wide ? static_cast<std::uint64_t>(value) : static_cast<std::uint32_t>(value);
              command.index = index;
              command.group = cell ? static_cast<std::uint16_t>(*cell >> 16) : group;
              if (cell) command.target = static_cast<std::uint16_t>(*cell & 0xFFFF);
              if (command.target != RS_ID_ALL && !CellIndex::valid(command.target)) {
                throw std::invalid_argument("cell id " + std::to_string(command.target) +
                                            " is not between 1 and 16382");
              }
              const std::optional<std::uint32_t> ticket = self.driver.command(command);
              if (!ticket) throw std::runtime_error("256 commands are waiting already: let the driver send them");
              return *ticket;
            });
          },
          "operation"_a, "value"_a = 0, "index"_a = 0, nb::kw_only(), "cell"_a = nb::none(), "group"_a = 0,
          R"(Sends a command (firmware/include/robotskin/operations.h) to one cell by its key, or to all of a group.
It goes out as soon as the section units have been heard. Returns the ticket that its replies carry.
Raises UnknownNameError for an unknown operation, InputError for a cell or value that cannot be, RuntimeError when 256
commands are waiting.)")
      .def(
          "leap_command_counter", [](HostDriver& self) { self.driver.leap_command_counter(); },
          R"(Lets the counter of commands go on a third of its round ahead.
Section units and host that were both started anew know no counter, but cells refuse what is not newer than their last
command, for 131 s. Where no cell of a skin answers, one of three such leaps is newer than whatever they know.)")
      .def(
          "power",
          [](HostDriver& self, bool on, std::uint16_t group, std::uint8_t unit, std::uint8_t port) {
            if (!self.driver.power({group, unit, port, on})) throw std::runtime_error("64 switches are waiting");
          },
          "on"_a, nb::kw_only(), "group"_a = 0, "unit"_a = 255, "port"_a = 0,
          "Switches the power of a section unit's port (0: all ports; unit 255: all units).")
      .def(
          "set_joints",
          [](HostDriver& self, unsigned limb, const std::vector<int>& positions, std::uint16_t group,
             std::optional<std::int64_t> now_ns) {
            with_input_errors([&] {
              LimbJoints joints{.set_ns = now_ns ? *now_ns : monotonic_ns(),
                                .group = group,
                                .limb = static_cast<std::uint8_t>(std::min(limb, 255U)),
                                .joints = static_cast<std::uint8_t>(std::min<std::size_t>(positions.size(), 255)),
                                .position = {}};
              for (std::size_t i = 0; i < std::min(positions.size(), joints.position.size()); ++i) {
                if (positions[i] < INT16_MIN || positions[i] > INT16_MAX)
                  throw std::invalid_argument("position " + std::to_string(positions[i]) + " does not fit 16 bits");
                joints.position[i] = static_cast<std::int16_t>(positions[i]);
              }
              if (!self.driver.joints(joints))
                throw std::invalid_argument("limb " + std::to_string(limb) + " with " +
                                            std::to_string(positions.size()) +
                                            " joints: there are limbs 0 to 15 of 1 to 24 joints, 64 in all");
            });
          },
          "limb"_a, "positions"_a, nb::kw_only(), "group"_a = 0, "now_ns"_a = nb::none(),
          R"(Where the joints of a limb are, (n,) in 2 pi / 65536 rad or 2^-15 m, at `now_ns` (by default now).
The newest positions go to the cells once an epoch of 4 ms; positions older than 20 ms do not.
Raises InputError for a limb, a count or a position that cannot be.)")
      .def(
          "torques", [](HostDriver& self) { return torques_dict(self.driver.torques()); },
          nb::sig("def torques(self) -> dict[str, numpy.ndarray]"),
          R"(The limbs' torques as the skin computes them, limb axis first: group, limb, epoch, joint (L, 24) in
the limb's step, cells (L, 4) summed by part of six joints, active (cells in contact), age (epochs of the oldest joint
positions used), saturated, whole (every source is in it), heard_ns, epoch_ns (when its epoch began), and the counts
vectors and partial. Not beside a TorqueReader in another thread.)")
      .def(
          "replies", [](HostDriver& self) { return replies_list(self.driver); },
          nb::sig("def replies(self) -> list[dict[str, int | str]]"),
          R"(Answers to commands since the last call: key, operation, status, ticket, index, value now in force and the
operation it is `of`, heard_ns, and the version of the cell's firmware.)")
      .def(
          "samples", [](HostDriver& self) { return samples_dict(self.driver.samples()); },
          nb::sig("def samples(self) -> dict[str, numpy.ndarray]"),
          "The newest published samples in counts, cell axis first. Not beside a SkinReader in another thread.")
      .def(
          "topology", [](HostDriver& self) { return topology_dict(self.driver.topology(), self.driver.samples()); },
          nb::sig("def topology(self) -> dict[str, numpy.ndarray]"),
          R"(Neighbours as the cells report them, cell axis first: key, heard_ns (0: never), uid, parent_port,
closed_port (by wrong tags, now or lately; 0: none, 5: orders under its own key), neighbour_id (N, 4),
neighbour_port (N, 4), errors (N, 4) by own port - 1. id 0: none, 16383: a section unit.)")
      .def(
          "units", [](HostDriver& self) { return units_list(self.driver.units()); },
          nb::sig("def units(self) -> list[dict]"), "Section units heard so far, with the tree below each port.")
      .def(
          "statistics", [](const HostDriver& self) { return statistics_dict(self.driver.statistics()); },
          nb::sig("def statistics(self) -> dict[str, int]"), "All counts since the driver was made.")
      .def(
          "latency_histogram",
          [](const HostDriver& self) {
            const LatencyHistogram& histogram = self.driver.statistics().latency;
            return filled<std::uint64_t>(LatencyHistogram::steps, 1,
                                         [&](std::size_t i, std::size_t) { return histogram.count[i].get(); });
          },
          nb::sig("def latency_histogram(self) -> numpy.ndarray"),
          "Datagrams by their time from the section unit to the snapshot, beyond the least: counts of 10 us steps.");
}

}  // namespace robotskin::bindings
