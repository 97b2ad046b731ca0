// SPDX-License-Identifier: Apache-2.0
// Binds the section unit's firmware; its keyed hash is any Python function from bytes to a tag.
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bindings/firmware_bytes.hpp"
#include "bindings/lab.hpp"
#include "robotskin/section_unit.h"

namespace robotskin::bindings {
namespace {

namespace nb = nanobind;
using namespace nb::literals;

struct UnitOutput {
  std::vector<nb::object> frames;
  std::optional<nb::bytes> datagram, to_peers;
  std::uint64_t timer_ns;
  std::uint16_t power;
};

class SectionUnit {
 public:
  SectionUnit() = default;
  SectionUnit(const SectionUnit&) = delete;
  SectionUnit& operator=(const SectionUnit&) = delete;

  UnitOutput boot(std::uint64_t now_ns, unsigned ports, std::uint32_t session, std::uint16_t group, unsigned unit,
                  std::uint16_t first_id, std::uint16_t last_id, std::uint32_t batch_us, bool unasked, bool powered,
                  const std::optional<nb::bytes>& cell_key, std::optional<nb::callable> tag, std::uint32_t turns) {
    tag_ = std::move(tag);
    cell_key_.clear();
    if (cell_key) {
      const std::uint8_t* key = exactly(*cell_key, RS_CELL_KEY_BYTES, "a key");
      cell_key_.assign(key, key + RS_CELL_KEY_BYTES);
    }
    rs_section_unit_config config{};
    config.group = group;
    config.unit = static_cast<std::uint8_t>(unit);
    config.ports = static_cast<std::uint8_t>(ports);
    config.first_id = first_id;
    config.last_id = last_id;
    config.batch_us = batch_us;
    config.session = session;
    config.powered = powered;
    config.unasked = unasked;
    config.cell_key = cell_key_.empty() ? nullptr : cell_key_.data();
    config.turns = turns;
    config.tag = tag_ ? &SectionUnit::tag : nullptr;
    config.tag_context = this;
    rs_unit_input input{};
    input.kind = RS_UNIT_INPUT_BOOT;
    input.config = &config;
    UnitOutput output = step(input, now_ns);
    if (output.timer_ns == UINT64_MAX) {
      throw nb::value_error(
          "a section unit has 1 to 15 ports, unit 0 to 15, 1 <= first_id <= last_id <= 16382 and a session");
    }
    return output;
  }

  UnitOutput frame(unsigned port, const nb::bytes& bytes, std::uint64_t now_ns) {
    rs_unit_input input{};
    input.kind = RS_UNIT_INPUT_FRAME;
    input.port = static_cast<std::uint8_t>(port);
    input.bytes = exactly(bytes, RS_FRAME_BYTES, "a frame");
    return step(input, now_ns);
  }

  UnitOutput sent(unsigned port, std::uint64_t now_ns) {
    rs_unit_input input{};
    input.kind = RS_UNIT_INPUT_SENT;
    input.port = static_cast<std::uint8_t>(port);
    return step(input, now_ns);
  }

  UnitOutput datagram(const nb::bytes& bytes, std::uint64_t now_ns) {
    rs_unit_input input{};
    input.kind = RS_UNIT_INPUT_DATAGRAM;
    input.bytes = static_cast<const std::uint8_t*>(bytes.data());
    input.count = static_cast<std::uint32_t>(bytes.size());
    return step(input, now_ns);
  }

  UnitOutput timer(std::uint64_t now_ns) {
    rs_unit_input input{};
    input.kind = RS_UNIT_INPUT_TIMER;
    return step(input, now_ns);
  }

  const rs_section_unit& state() const { return *state_; }

 private:
  static void tag(void* context, const std::uint8_t* bytes, std::uint32_t count, std::uint8_t* tag) {
    const nb::bytes result = nb::cast<nb::bytes>((*static_cast<SectionUnit*>(context)->tag_)(as_bytes(bytes, count)));
    const std::uint8_t* data = exactly(result, RS_DATAGRAM_TAG_BYTES, "a tag");
    std::copy_n(data, RS_DATAGRAM_TAG_BYTES, tag);
  }

  UnitOutput step(const rs_unit_input& input, std::uint64_t now_ns) {
    rs_unit_output raw;
    rs_section_unit_step(state_.get(), &input, now_ns, &raw);
    UnitOutput output{};
    for (unsigned port = 0; port < state_->config.ports; ++port) {
      output.frames.push_back(raw.frame[port] != nullptr ? nb::object(as_bytes(raw.frame[port], RS_FRAME_BYTES))
                                                         : nb::none());
    }
    if (raw.datagram != nullptr)
      (raw.to_peers ? output.to_peers : output.datagram) = as_bytes(raw.datagram, raw.datagram_bytes);
    output.timer_ns = raw.timer_ns;
    output.power = raw.power;
    return output;
  }

  std::unique_ptr<rs_section_unit> state_ = std::make_unique<rs_section_unit>();
  std::vector<std::uint8_t> cell_key_;
  std::optional<nb::callable> tag_;
};

nb::list ports_of(const SectionUnit& unit) {
  nb::list list;
  for (unsigned port = 0; port < unit.state().config.ports; ++port) {
    const rs_unit_port& here = unit.state().port[port];
    nb::dict entry;
    entry["cell"] = here.cell;
    entry["root"] = here.root;
    entry["size"] = here.size;
    entry["height"] = here.height;
    entry["frames"] = here.frames;
    entry["lost"] = here.lost;
    entry["dropped"] = here.dropped;
    list.append(entry);
  }
  return list;
}

}  // namespace

void bind_firmware_section_unit(nb::module_& module) {
  nb::class_<UnitOutput>(module, "SectionUnitOutput", "What a section unit asks for (section_unit.h).")
      .def_ro("frames", &UnitOutput::frames, "frame to start on each port, or None")
      .def_ro("datagram", &UnitOutput::datagram, "to the host, or None")
      .def_ro("to_peers", &UnitOutput::to_peers, "a datagram to every other unit of the group, or None")
      .def_ro("timer_ns", &UnitOutput::timer_ns)
      .def_ro("power", &UnitOutput::power, "bit p - 1: port p has power");

  nb::class_<SectionUnit>(
      module, "SectionUnit",
      "The firmware of one section unit (section_unit.h): boot it, then one input at a time. Times are "
      "nanoseconds of its clock. `tag` maps bytes to a tag of 16 bytes; None: no authentication.")
      .def(nb::init<>())
      .def("boot", &SectionUnit::boot, "now_ns"_a, "ports"_a, "session"_a, nb::kw_only(), "group"_a = 0, "unit"_a = 0,
           "first_id"_a = static_cast<int>(RS_ID_FIRST), "last_id"_a = static_cast<int>(RS_ID_LAST),
           "batch_us"_a = 1000, "unasked"_a = false, "powered"_a = true, "cell_key"_a = nb::none(),
           "tag"_a = nb::none(), "turns"_a = 0)
      .def("frame", &SectionUnit::frame, "port"_a, "frame"_a, "now_ns"_a)
      .def("sent", &SectionUnit::sent, "port"_a, "now_ns"_a)
      .def("datagram", &SectionUnit::datagram, "datagram"_a, "now_ns"_a)
      .def("timer", &SectionUnit::timer, "now_ns"_a)
      .def_prop_ro("ports", &ports_of)
      .def_prop_ro("dropped", [](const SectionUnit& unit) { return unit.state().dropped; })
      .def_prop_ro("refused", [](const SectionUnit& unit) { return unit.state().refused; })
      .def_prop_ro("names", [](const SectionUnit& unit) {
        nb::dict names;
        for (const rs_unit_name& name : unit.state().ids.entry) {
          if (name.uid != 0 && name.id != RS_ID_NONE) names[nb::int_(name.uid)] = name.id;
        }
        return names;
      });
}

}  // namespace robotskin::bindings
