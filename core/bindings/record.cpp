// SPDX-License-Identifier: Apache-2.0
// Binds recording: tapes that look on while a robot works, and the player of what they took down.
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>

#include <cstring>

#include "bindings/bindings.hpp"
#include "bindings/bytes.hpp"
#include "bindings/driver.hpp"
#include "model/joint_command.hpp"
#include "model/joint_state.hpp"
#include "record/player.hpp"
#include "record/recorder.hpp"

namespace robotskin::bindings {
namespace {

namespace nb = nanobind;
using namespace nb::literals;
using record::Entry;

nb::bytes bytes_from(const std::vector<std::uint8_t>& data) {
  return nb::bytes(reinterpret_cast<const char*>(data.data()), data.size());
}

struct Recorder {
  Recorder(std::size_t driver_bytes, std::size_t control_bytes)
      : driver(driver_bytes), control(control_bytes, driver) {}

  record::DriverTape driver;
  record::ControlTape control;
};

constexpr std::size_t block_bytes = std::size_t{1} << 22;

// What was drained, without the decoded samples, and these apart: the one is stored, the others are encoded.
nb::tuple split_samples(const std::vector<std::uint8_t>& drained) {
  std::vector<std::uint8_t> kept, samples;
  kept.reserve(drained.size());
  for (std::size_t at = 0; at < drained.size();) {
    record::EntryHeader header;
    std::memcpy(&header, drained.data() + at, sizeof header);
    const std::size_t bytes = record::entry_bytes(header.bytes);
    const auto from = drained.begin() + static_cast<std::ptrdiff_t>(at);
    if (header.kind == static_cast<std::uint16_t>(Entry::sample)) {
      samples.insert(samples.end(), from + sizeof header, from + static_cast<std::ptrdiff_t>(bytes));
    } else {
      kept.insert(kept.end(), from, from + static_cast<std::ptrdiff_t>(bytes));
    }
    at += bytes;
  }
  return nb::make_tuple(bytes_from(kept), bytes_from(samples));
}

void bind_recorder(nb::module_& module) {
  nb::class_<Recorder>(module, "Recorder", R"(Two bounded tapes, one of the driver's thread, one of the control thread.

What happens in these threads is copied into the tapes without waiting; `drain_driver` and `drain_control` empty them in
another thread. A full tape drops and counts, and goes on at the next keyframe.)")
      .def(
          "__init__",
          [](Recorder* self, double driver_mib, double control_mib) {
            new (self) Recorder(static_cast<std::size_t>(driver_mib * 1048576.0),
                                static_cast<std::size_t>(control_mib * 1048576.0));
          },
          "driver_mib"_a = 64.0, "control_mib"_a = 16.0)
      .def(
          "attach",
          [](Recorder& self, HostDriver& host, skin::SkinReader& reader) {
            host.driver.set_witness(&self.driver);
            reader.set_witness(&self.control);
          },
          "driver"_a, "reader"_a, nb::keep_alive<2, 1>(), nb::keep_alive<3, 1>(),
          "Takes down what this driver and this skin reader do from now on. Call it in the control thread.")
      .def(
          "detach",
          [](Recorder&, HostDriver& host, skin::SkinReader& reader) {
            host.driver.set_witness(nullptr);
            reader.set_witness(nullptr);
          },
          "driver"_a, "reader"_a, "Ends that. Call it in the control thread.")
      .def(
          "joints",
          [](Recorder& self, const JointState& state) {
            self.control.joints(state.stamp_ns, state.position, state.velocity, state.effort);
          },
          "state"_a, "Takes down a joint state.")
      .def(
          "command",
          [](Recorder& self, std::int64_t now_ns, const JointCommand& command) {
            self.control.command(now_ns, static_cast<std::uint64_t>(command.mode), command.value);
          },
          "now_ns"_a, "command"_a, "Takes down what was sent to the robot.")
      .def(
          "ask_for_keyframe", [](Recorder& self) { self.driver.ask_for_keyframe(); },
          "The next publication is followed by a keyframe, at which a replay can begin.")
      .def(
          "drain_driver",
          [](Recorder& self) {
            std::vector<std::uint8_t> out;
            {
              nb::gil_scoped_release release;
              self.driver.tape().drain(out, block_bytes);
            }
            return split_samples(out);
          },
          nb::sig("def drain_driver(self) -> tuple[bytes, bytes]"),
          "Entries of the driver's thread, at most some 4 MiB, and the decoded samples of that time, 64 bytes each.")
      .def(
          "drain_control",
          [](Recorder& self) {
            std::vector<std::uint8_t> out;
            self.control.tape().drain(out, block_bytes);
            return bytes_from(out);
          },
          nb::sig("def drain_control(self) -> bytes"), "Entries of the control thread, at most some 4 MiB.")
      .def_prop_ro(
          "dropped", [](Recorder& self) { return self.driver.tape().dropped() + self.control.tape().dropped(); },
          "Entries that found no room.");
}

void bind_player(nb::module_& module) {
  using record::Player;
  nb::class_<Player>(module, "Player", R"(Recorded blocks through the shipping driver and skin reader.

Give blocks in their order; `advance` goes on to the next read and fills a SkinState, equal to the byte to the one of
the recording. Raises InputError for bytes that no recorder writes.)")
      .def(
          "__init__",
          [](Player* self, const skin::SkinModel& model, std::size_t spare_cells, std::size_t spare_groups) {
            with_input_errors([&] { new (self) Player(model, spare_cells, spare_groups); });
          },
          "model"_a, "spare_cells"_a = 0, "spare_groups"_a = 0)
      .def(
          "give_driver",
          [](Player& self, const nb::bytes& block) { with_input_errors([&] { self.give_driver(bytes_of(block)); }); },
          "block"_a, "Entries of the driver's thread.")
      .def(
          "give_control",
          [](Player& self, const nb::bytes& block) { with_input_errors([&] { self.give_control(bytes_of(block)); }); },
          "block"_a, "Entries of the control thread.")
      .def(
          "advance",
          [](Player& self, skin::SkinState& state) { return with_input_errors([&] { return self.advance(state); }); },
          "state"_a, "The host time of the next read in ns, `state` filled; None where more blocks are needed.")
      .def("seek", &Player::seek, "Forgets all blocks given: goes on at the next keyframe in those to come.")
      .def_prop_ro("gaps", &Player::gaps, "Entries that the recorder had to drop so far.")
      .def_prop_ro(
          "joints",
          [](const Player& self) {
            const std::size_t n = self.joints().size() / 3;
            return filled<double>(3, n, [&](std::size_t i, std::size_t c) { return self.joints()[i * n + c]; });
          },
          nb::sig("def joints(self) -> numpy.ndarray"), "(3, n) position, velocity, effort as of the last read.")
      .def_prop_ro(
          "command",
          [](const Player& self) {
            return filled<double>(self.command().size(), 1,
                                  [&](std::size_t i, std::size_t) { return self.command()[i]; });
          },
          nb::sig("def command(self) -> numpy.ndarray"), "(n) last sent to the robot.")
      .def_prop_ro("command_mode", &Player::command_mode, "Number of its command mode.");
}

}  // namespace

void bind_record(nb::module_ module) {
  nb::enum_<Entry>(module, "Entry", "Kinds of entries on a tape.")
#define ROBOTSKIN_ENTRY(name, number, payload) .value(#name, Entry::name, payload)
      ROBOTSKIN_TAPE_ENTRIES(ROBOTSKIN_ENTRY)
#undef ROBOTSKIN_ENTRY
          ;
  bind_recorder(module);
  bind_player(module);
}

}  // namespace robotskin::bindings
