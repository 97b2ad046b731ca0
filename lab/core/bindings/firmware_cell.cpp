// SPDX-License-Identifier: Apache-2.0
// Binds one cell's firmware, so that Python can put it into a network of its own making.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <vector>

#include "bindings/contribution.hpp"
#include "bindings/firmware_bytes.hpp"
#include "bindings/lab.hpp"
#include "robotskin/cell.h"

namespace robotskin::bindings {
namespace {

namespace nb = nanobind;
using namespace nb::literals;

struct CellOutput {
  std::array<nb::object, RS_PORTS> frames;
  std::uint32_t timer_us;
  std::optional<std::uint32_t> sample_us;
  std::optional<std::uint32_t> led_rgb;
  std::optional<nb::bytes> flash;
};

class Cell {
 public:
  CellOutput boot(std::uint32_t uid, std::uint32_t random, std::uint32_t now_us, const std::optional<nb::bytes>& flash,
                  const std::optional<nb::bytes>& key) {
    if (uid == 0) throw nb::value_error("a cell's uid is not 0");
    std::array<std::uint8_t, RS_CELL_KEYS_BYTES> keys;
    if (key) rs_cell_keys(exactly(*key, RS_CELL_KEY_BYTES, "a secret"), uid, keys.data());
    const rs_boot with{uid, random, flash ? exactly(*flash, RS_FLASH_BYTES, "a flash image") : nullptr,
                       key ? keys.data() : nullptr};
    rs_input input{};
    input.kind = RS_INPUT_BOOT;
    input.boot = &with;
    return step(input, now_us);
  }

  CellOutput frame(unsigned port, const nb::bytes& bytes, std::uint32_t now_us, std::uint16_t late_us) {
    rs_input input{};
    input.kind = RS_INPUT_FRAME;
    input.port = static_cast<std::uint8_t>(port);
    input.frame = exactly(bytes, RS_FRAME_BYTES, "a frame");
    input.late_us = late_us;
    return step(input, now_us);
  }

  CellOutput sent(unsigned port, std::uint32_t now_us) {
    rs_input input{};
    input.kind = RS_INPUT_SENT;
    input.port = static_cast<std::uint8_t>(port);
    return step(input, now_us);
  }

  CellOutput sample(const std::array<std::int32_t, RS_CHANNEL_COUNT>& values, std::uint32_t now_us, bool fault) {
    rs_sample taken;
    std::copy(values.begin(), values.end(), taken.value);
    rs_input input{};
    input.kind = RS_INPUT_SAMPLE;
    input.fault = fault;
    input.sample = &taken;
    return step(input, now_us);
  }

  CellOutput timer(std::uint32_t now_us) {
    rs_input input{};
    input.kind = RS_INPUT_TIMER;
    return step(input, now_us);
  }

  void contribute(unsigned limb, const std::vector<std::int32_t>& torque, bool active, unsigned age) {
    const rs_contribution contribution = contribution_of(limb, torque, active, age);
    rs_cell_contribute(&state_, &contribution);
  }

  const rs_cell& state() const { return state_; }

 private:
  CellOutput step(const rs_input& input, std::uint32_t now_us) {
    rs_output raw;
    rs_cell_step(&state_, &input, now_us, &raw);
    CellOutput output{};
    for (std::size_t port = 0; port < RS_PORTS; ++port) {
      output.frames[port] =
          raw.frame[port] != nullptr ? nb::object(as_bytes(raw.frame[port], RS_FRAME_BYTES)) : nb::none();
    }
    output.timer_us = raw.timer_us;
    if (raw.sampling) output.sample_us = raw.sample_us;
    if (raw.led_changed) output.led_rgb = raw.led_rgb;
    if (raw.flash_changed) output.flash = as_bytes(raw.flash, RS_FLASH_BYTES);
    return output;
  }

  rs_cell state_{};
};

nb::dict counts_of(const Cell& cell) {
  nb::dict counts;
#define COUNT(name, text) counts[#name] = cell.state().counts.name;
  RS_CELL_COUNTS(COUNT)
#undef COUNT
  return counts;
}

nb::list neighbours_of(const Cell& cell) {
  nb::list list;
  for (const rs_neighbour& neighbour : cell.state().route.neighbour) {
    nb::dict entry;
    entry["up"] = neighbour.up;
    entry["hears_us"] = neighbour.hears_us;
    entry["child"] = neighbour.child;
    entry["id"] = neighbour.id;
    entry["port"] = neighbour.port;
    entry["hops"] = neighbour.hops;
    entry["sequence"] = neighbour.wave.sequence;
    entry["lost"] = neighbour.lost;
    list.append(entry);
  }
  return list;
}

}  // namespace

void bind_firmware_cell(nb::module_& module) {
  nb::class_<CellOutput>(module, "CellOutput", "What a cell asks for (cell.h): frames to start, times, LED, flash.")
      .def_ro("frames", &CellOutput::frames, "frame to start on ports 1 to 4, or None")
      .def_ro("timer_us", &CellOutput::timer_us)
      .def_ro("sample_us", &CellOutput::sample_us, "None: the cell does not sample")
      .def_ro("led_rgb", &CellOutput::led_rgb, "None: unchanged")
      .def_ro("flash", &CellOutput::flash, "None: nothing to write");

  nb::class_<Cell>(module, "Cell",
                   "The firmware of one cell (cell.h): give it one input at a time, do what the output says. Times are "
                   "microseconds of the cell's clock, modulo 2**32; ports are 1 to 4.")
      .def(nb::init<>())
      .def("boot", &Cell::boot, "uid"_a, "random"_a, "now_us"_a, "flash"_a = nb::none(), "key"_a = nb::none())
      .def("frame", &Cell::frame, "port"_a, "frame"_a, "now_us"_a, "late_us"_a = 0)
      .def("sent", &Cell::sent, "port"_a, "now_us"_a)
      .def("sample", &Cell::sample, "values"_a, "now_us"_a, "fault"_a = false)
      .def("timer", &Cell::timer, "now_us"_a)
      .def("contribute", &Cell::contribute, "limb"_a, "torque"_a, "active"_a = false, "age"_a = 0,
           "What the cell adds to its limb's joints in each epoch, in the limb's step; up to 12 joints, none: nothing.")
      .def_prop_ro(
          "contribution",
          [](const Cell& cell) {
            const rs_contribution& own = cell.state().torque.own;
            nb::dict dict;
            dict["limb"] = own.limb;
            dict["parts"] = own.parts;
            dict["joint"] = std::vector<std::int32_t>(std::begin(own.joint), std::end(own.joint));
            dict["active"] = own.active != 0;
            dict["age"] = own.age;
            return dict;
          },
          "what it added in the last epoch; 0 parts: nothing")
      .def_prop_ro(
          "torque_known", [](const Cell& cell) { return cell.state().cell_torque.known != 0; },
          "it has the parameters to compute its own torque")
      .def_prop_ro(
          "joint_positions",
          [](const Cell& cell) {
            const rs_joints_state& joints = cell.state().joints;
            return std::vector<int>(std::begin(joints.position), std::end(joints.position));
          },
          "of the limb that the cell contributes to, as last broadcast, in 2 pi / 65536 rad")
      .def_prop_ro("id", [](const Cell& cell) { return cell.state().id; })
      .def_prop_ro("uid", [](const Cell& cell) { return cell.state().uid; })
      .def_prop_ro("challenge", [](const Cell& cell) { return cell.state().challenge; })
      .def_prop_ro(
          "parent_port", [](const Cell& cell) { return cell.state().route.parent_port; }, "0: no parent")
      .def_prop_ro("hops", [](const Cell& cell) { return cell.state().route.hops; })
      .def_prop_ro("root", [](const Cell& cell) { return cell.state().route.wave.root; })
      .def_prop_ro("sequence", [](const Cell& cell) { return cell.state().route.wave.sequence; })
      .def_prop_ro(
          "feasible_distance",
          [](const Cell& cell) {
            const rs_route& route = cell.state().route;
            return nb::make_tuple(route.unbound, route.feasible_sequence, route.feasible_hops);
          },
          "(none yet, sequence, hops)")
      .def_prop_ro("subtree_size", [](const Cell& cell) { return cell.state().route.subtree_size; })
      .def_prop_ro("subtree_height", [](const Cell& cell) { return cell.state().route.subtree_height; })
      .def_prop_ro("in_quarantine", [](const Cell& cell) { return cell.state().route.in_quarantine; })
      .def_prop_ro("neighbours", &neighbours_of)
      .def_prop_ro("counts", &counts_of)
      .def_prop_ro(
          "waiting",
          [](const Cell& cell) {
            const rs_queues& queues = cell.state().queues;
            const rs_arq_ring& events = cell.state().arq_sender.event;
            return nb::make_tuple(events.count - events.sent, queues.data.count, queues.slow.count, queues.down.count);
          },
          "frames that wait: events, clock samples, slow ones, downward ones")
      .def_prop_ro(
          "state",
          [](const Cell& cell) {
            return as_bytes(reinterpret_cast<const std::uint8_t*>(&cell.state()), sizeof(rs_cell));
          },
          "the whole state, to compare two runs");
}

}  // namespace robotskin::bindings
