// SPDX-License-Identifier: Apache-2.0
// Binds the place in a network where a cell is run elsewhere.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <cstring>

#include "bindings/world.hpp"
#include "world/network/external_cell.hpp"

namespace robotskin::bindings {
namespace {

namespace nb = nanobind;
using namespace nb::literals;
using world::ExternalCell;
using world::ExternalCellOutput;

nb::object bytes_or_none(const std::uint8_t* data, std::size_t count) {
  if (data == nullptr) return nb::none();
  return nb::bytes(reinterpret_cast<const char*>(data), count);
}

nb::object content_of(const rs_input& input) {
  switch (input.kind) {
    case RS_INPUT_BOOT:
      return nb::make_tuple(input.boot->uid, input.boot->random, bytes_or_none(input.boot->flash, RS_FLASH_BYTES),
                            bytes_or_none(input.boot->keys, RS_CELL_KEYS_BYTES), input.boot->step_us);
    case RS_INPUT_FRAME:
      return nb::make_tuple(bytes_or_none(input.frame, RS_FRAME_BYTES), input.late_us);
    case RS_INPUT_SAMPLE:
      return bytes_or_none(reinterpret_cast<const std::uint8_t*>(input.sample->value), sizeof input.sample->value);
    default:
      return nb::none();
  }
}

std::optional<std::uint32_t> number_or_none(const nb::handle& value) {
  if (value.is_none()) return std::nullopt;
  return nb::cast<std::uint32_t>(value);
}

ExternalCellOutput output_of(const nb::tuple& answer) {
  ExternalCellOutput output;
  const auto frames = nb::cast<nb::tuple>(answer[0]);
  for (std::size_t port = 0; port < RS_PORTS; ++port) {
    if (frames[port].is_none()) continue;
    const auto frame = nb::cast<nb::bytes>(frames[port]);
    if (frame.size() != RS_FRAME_BYTES) throw nb::value_error("an external cell's frame has 20 bytes");
    std::memcpy(output.frame[port].emplace().data(), frame.c_str(), RS_FRAME_BYTES);
  }
  output.timer_us = nb::cast<std::uint32_t>(answer[1]);
  output.sample_us = number_or_none(answer[2]);
  output.waiting = nb::cast<std::uint8_t>(answer[3]);
  output.led_rgb = number_or_none(answer[4]);
  if (!answer[5].is_none()) {
    const auto flash = nb::cast<nb::bytes>(answer[5]);
    if (flash.size() != RS_FLASH_BYTES) throw nb::value_error("an external cell's flash image has another length");
    const auto* data = reinterpret_cast<const std::uint8_t*>(flash.c_str());
    output.flash.emplace(data, data + flash.size());
  }
  output.restart = nb::cast<bool>(answer[6]);
  return output;
}

}  // namespace

void bind_world_external_cell(nb::module_& module) {
  nb::list kinds;
  for (const std::string_view name : world::input_kind_names) kinds.append(nb::str(name.data(), name.size()));
  module.attr("INPUT_KINDS") = kinds;
  nb::class_<ExternalCell>(module, "ExternalCell",
                           "A cell run elsewhere in place of one of the network's own, and compared with it.")
      .def(
          "__init__",
          [](ExternalCell* self, nb::callable step) {
            new (self) ExternalCell([step](const rs_input& input, std::uint32_t now_us) {
              const nb::gil_scoped_acquire gil;
              return output_of(nb::cast<nb::tuple>(
                  step(static_cast<int>(input.kind), input.port, input.sent, input.fault, content_of(input), now_us)));
            });
          },
          "step"_a,
          "`step(kind, port, sent, fault, content, now_us)`, an input of cell.h; content: boot (uid, random, flash, "
          "key, step_us), a frame and its late_us, or the sample as 32-bit integers. Answers (frames of 4 ports, "
          "timer_us, sample_us or None, waiting, led_rgb or None, flash or None, restart).")
      .def_prop_ro(
          "input_kind",
          [](const ExternalCell& self) {
            const std::string_view name = world::input_kind_names[static_cast<std::size_t>(self.kind())];
            return nb::str(name.data(), name.size());
          },
          "of the input that it has now, as processing time tells them apart")
      .def_prop_ro("steps", &ExternalCell::steps, "inputs that it has answered")
      .def_prop_ro("samples", &ExternalCell::samples, "of those, that were samples")
      .def_prop_ro("frames", &ExternalCell::frames, "that the external cell sent")
      .def_prop_ro("differences", &ExternalCell::differences,
                   "steps in which it answered otherwise than the host-built cell")
      .def_prop_ro("first_difference", &ExternalCell::first_difference, "what and when; empty: none");
}

}  // namespace robotskin::bindings
