// SPDX-License-Identifier: Apache-2.0
// Binds recording: tapes that look on while a robot works, and the player of what they took down.
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>

#include <array>
#include <cstring>
#include <utility>

#include "bindings/bindings.hpp"
#include "bindings/bytes.hpp"
#include "bindings/driver.hpp"
#include "bindings/driver_tables.hpp"
#include "loop/skin_loop.hpp"
#include "record/player.hpp"
#include "record/recorder.hpp"
#include "record/tape_reader.hpp"

namespace robotskin::bindings {
namespace {

namespace nb = nanobind;
using namespace nb::literals;
using record::Entry;

using Memory = nb::ndarray<std::uint8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

std::span<std::uint8_t> span_of(const Memory& memory) {
  return {memory.data(), memory.shape(0)};
}

nb::bytes bytes_from(std::span<const std::uint8_t> data) {
  return nb::bytes(reinterpret_cast<const char*>(data.data()), data.size());
}

struct Recorder final : loop::LoopWitness {
  Recorder(Memory driver_memory, Memory control_memory)
      : driver(span_of(driver_memory)),
        control(span_of(control_memory), driver),
        memory{std::move(driver_memory), std::move(control_memory)} {}

  void ticked(std::int64_t now_ns, const loop::SkinLoop& loop) noexcept override {
    if (without_driver && loop.report().input == skin::InputStatus::ok)
      control.felt(loop.skin(), fresh_ns, now_ns);
    else if (without_driver)
      control.nothing_felt(now_ns);
    const std::uint64_t before = std::exchange(clock_ticks, loop.fusion_counts().clock_ticks);
    moved(now_ns, loop.joints(), loop.report().write == PortStatus::ok ? &loop.command() : nullptr,
          clock_ticks != before);
  }

  // What a robot told and, where something was, what was sent to it, and whether a clock ended that tick.
  void moved(std::int64_t now_ns, const JointState& joints, const JointCommand* sent, bool by_clock = false) noexcept {
    if (joints.stamp_ns != never_ns) control.joints(joints.stamp_ns, joints.position, joints.velocity, joints.effort);
    if (sent == nullptr) return;
    const std::optional<CommandMode> mode = sent->common_mode();
    control.command(now_ns, mode ? static_cast<std::uint64_t>(*mode) : record::modes_differ, sent->value, by_clock);
  }

  std::uint64_t dropped() const {
    return is_closed() ? dropped_before_closed : driver.tape().dropped() + control.tape().dropped();
  }
  bool is_closed() const { return !memory[0].is_valid(); }
  // What it was attached to keeps it alive, but not its memory.
  void close() {
    dropped_before_closed = dropped();
    memory = {};
  }
  Recorder& require_open() {
    if (is_closed()) throw std::invalid_argument("this recorder is closed: make another one");
    return *this;
  }

  record::DriverTape driver;
  record::ControlTape control;
  std::array<Memory, 2> memory;  // of both tapes; none once it is closed
  std::uint64_t dropped_before_closed = 0;
  bool without_driver = false;
  std::int64_t fresh_ns = 0;      // of such a skin
  std::uint64_t clock_ticks = 0;  // of the loop, as of the last tick
};

struct Reader {
  Reader(Memory driver, Memory control, std::size_t reader, const skin::SkinModel& model)
      : tapes(span_of(driver), span_of(control), reader, model), memory{std::move(driver), std::move(control)} {}

  record::TapeReader tapes;
  std::array<Memory, 2> memory;
};

void require_reader(std::size_t reader) {
  if (reader >= record::Tape::readers)
    throw std::invalid_argument("reader " + std::to_string(reader) + ": a tape has " +
                                std::to_string(record::Tape::readers) + ", from 0");
}

template <class Item>
nb::bytes column(const std::vector<Item>& items) {
  return nb::bytes(reinterpret_cast<const char*>(items.data()), items.size() * sizeof(Item));
}

void bind_recorder(nb::module_& module) {
  module.attr("KEYFRAME_S") = 1e-9 * static_cast<double>(record::DriverTape::keyframe_period_ns);
  nb::class_<Recorder>(module, "Recorder", R"(Two bounded tapes, one of the driver's thread, one of the control thread.

What happens in these threads is copied into the tapes without waiting; a `TapeReader` empties them in another thread or
another process. A full tape drops and counts, and goes on at the next keyframe.)")
      .def(nb::init<Memory, Memory>(), "driver"_a, "control"_a,
           "Fresh tapes in two pieces of memory (bytes,) u8, writable and aligned to 64 bytes; each takes the largest "
           "power of two that has room. Raises ValueError where one is too small or askew.")
      .def(
          "begin_reading",
          [](Recorder& self, std::size_t reader) {
            require_reader(reader);
            self.require_open().driver.tape().begin_reading(reader);
            self.control.tape().begin_reading(reader);
          },
          "reader"_a, "What is taken down from now on waits for this reader, 0 or 1.")
      .def(
          "end_reading",
          [](Recorder& self, std::size_t reader) {
            require_reader(reader);
            if (self.is_closed()) return;
            self.driver.tape().end_reading(reader);
            self.control.tape().end_reading(reader);
          },
          "reader"_a, "Nothing waits for it any more.")
      .def(
          "attach",
          [](Recorder& self, HostDriver* host, skin::SkinReader* reader, loop::SkinLoop* loop) {
            self.require_open();
            if (host != nullptr) host->driver.set_witness(&self.driver);
            if (reader != nullptr) reader->set_witness(&self.control);
            if (loop == nullptr) return;
            self.without_driver = host == nullptr;
            self.fresh_ns = loop->input().fresh_ns();
            self.clock_ticks = loop->fusion_counts().clock_ticks;
            loop->set_witness(&self);
          },
          "driver"_a.none(), "reader"_a.none(), "loop"_a.none() = nb::none(), nb::keep_alive<2, 1>(),
          nb::keep_alive<3, 1>(), nb::keep_alive<4, 1>(),
          "Takes down what driver, skin reader and loop do from now on; of a skin without driver and reader, what the "
          "loop feels. Call it in the control thread.")
      .def(
          "detach",
          [](Recorder&, HostDriver* host, skin::SkinReader* reader, loop::SkinLoop* loop) {
            if (host != nullptr) host->driver.set_witness(nullptr);
            if (reader != nullptr) reader->set_witness(nullptr);
            if (loop != nullptr) loop->set_witness(nullptr);
          },
          "driver"_a.none(), "reader"_a.none(), "loop"_a.none() = nb::none(),
          "Ends that. Call it in the control thread.")
      .def("close", &Recorder::close,
           "Gives the memory of the tapes back, once it is detached and their readers need nothing of it any more.")
      .def(
          "moved",
          [](Recorder& self, std::int64_t now_ns, const JointState& joints, const JointCommand* sent) {
            self.require_open().moved(now_ns, joints, sent);
          },
          "now_ns"_a, "joints"_a, "sent"_a.none(),
          "What a robot told at `now_ns`, and what was sent to it or None, where no loop is attached. Call it in the "
          "control thread.")
      .def(
          "ask_for_keyframe", [](Recorder& self) { self.driver.ask_for_keyframe(); },
          "The next publication is followed by a keyframe, at which a replay can begin.")
      .def_prop_ro("dropped", &Recorder::dropped, "Entries that found no room.");
}

void bind_reader(nb::module_& module) {
  nb::class_<Reader>(module, "TapeReader", "One reader of a recorder's two tapes, in any thread of any process.")
      .def(
          "__init__",
          [](Reader* self, Memory driver, Memory control, std::size_t reader, const skin::SkinModel& model) {
            require_reader(reader);
            new (self) Reader(std::move(driver), std::move(control), reader, model);
          },
          "driver"_a, "control"_a, "reader"_a, "model"_a,
          "driver, control: (bytes,) u8, the memory of the recorder's tapes. model: of the skin whose samples come. "
          "Raises "
          "ValueError where no tape can be.")
      .def(
          "drain_driver",
          [](Reader& self) {
            std::span<const std::uint8_t> kept;
            {
              nb::gil_scoped_release release;
              kept = self.tapes.drain_driver();
            }
            const record::SampleColumns& samples = self.tapes.samples;
            nb::dict columns;
            columns["key"] = column(samples.key);
            columns["stamp_ns"] = column(samples.stamp_ns);
#define ROBOTSKIN_KEEP(name, is_signed, first, channels, values, blank, unit) columns[#values] = column(samples.values);
            RS_SENSORS(ROBOTSKIN_KEEP)
#undef ROBOTSKIN_KEEP
            columns["flags"] = column(samples.flags);
            return nb::make_tuple(bytes_from(kept), columns);
          },
          nb::sig("def drain_driver(self) -> tuple[bytes, dict[str, bytes]]"),
          R"(Entries of the driver's thread, at most some 4 MiB, and the decoded samples of that time, a column of
little-endian numbers each: key u32, stamp_ns i64, f32 of each sensor by its column (`firmware.SENSORS`), SI units, flags
u32 (1: an event, 2: a sensor's fault, 4: for freshness).)")
      .def(
          "drain_control", [](Reader& self) { return bytes_from(self.tapes.drain_control()); },
          nb::sig("def drain_control(self) -> bytes"), "Entries of the control thread, at most some 4 MiB.")
      .def(
          "set_zero",
          [](Reader& self, const nb::bytes& force_offset) {
            std::vector<float> values(force_offset.size() / sizeof(float));
            std::memcpy(values.data(), force_offset.data(), values.size() * sizeof(float));
            self.tapes.samples.set_zero(values);
          },
          "force_offset"_a, "What is taken from the forces of samples from now on: (N, 3) f32 newton.");
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
      .def_prop_ro(
          "measured_force",
          [](nb::handle_t<Player> self) {
            const auto& forces = nb::cast<Player&>(self).measured_force();
            const std::size_t shape[2] = {forces.size(), 3};
            return nb::ndarray<nb::numpy, const float>(forces.data()->data(), 2, shape, self);
          },
          nb::rv_policy::automatic, nb::sig("def measured_force(self) -> numpy.ndarray"),
          "(N, 3) newton as of the last read, before any zero is taken; it shares the player's memory.")
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
      .def_prop_ro("command_mode", &Player::command_mode, "Number of its command mode.")
      .def_prop_ro("command_by_clock", &Player::command_by_clock,
                   "Whether a clock ended the fusion of its tick, so that nothing repeats it.")
      .def(
          "topology", [](Player& self) { return topology_dict(self.driver().topology(), self.driver().samples()); },
          nb::sig("def topology(self) -> dict[str, numpy.ndarray]"),
          "Neighbours as the cells reported them up to the last read, as `Driver.topology`.")
      .def(
          "statistics", [](Player& self) { return statistics_dict(self.driver().statistics()); },
          nb::sig("def statistics(self) -> dict[str, int]"),
          "Counts of the datagrams played so far, as `Driver.statistics`.");
}

}  // namespace

void bind_record(nb::module_ module) {
  nb::enum_<Entry>(module, "Entry", "Kinds of entries on a tape.")
#define ROBOTSKIN_ENTRY(name, number, payload) .value(#name, Entry::name, payload)
      ROBOTSKIN_TAPE_ENTRIES(ROBOTSKIN_ENTRY)
#undef ROBOTSKIN_ENTRY
          ;
  bind_recorder(module);
  bind_reader(module);
  bind_player(module);
}

}  // namespace robotskin::bindings
