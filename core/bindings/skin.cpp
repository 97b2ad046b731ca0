// SPDX-License-Identifier: Apache-2.0
// Binds the skin stage: the skin model by copies, the skin state by views that share its memory.
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <set>
#include <string>
#include <tuple>

#include "bindings/arrays.hpp"
#include "bindings/bindings.hpp"
#include "bindings/driver.hpp"
#include "bindings/sensor_names.hpp"
#include "skin/calibration.hpp"
#include "skin/skin_model.hpp"
#include "skin/skin_reader.hpp"
#include "skin/skin_state.hpp"
#include "skin/torque_reader.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::bindings {
namespace {

using skin::Health;
using skin::SkinModel;
using skin::SkinReader;
using skin::SkinState;

template <typename Value, typename Shape>
using Input = nb::ndarray<const Value, Shape, nb::c_contig, nb::device::cpu>;

void require_cells(const char* name, std::size_t given, std::size_t cells) {
  if (given != cells)
    throw std::invalid_argument(std::string(name) + " has " + std::to_string(given) + " entries, key has " +
                                std::to_string(cells));
}

void demand(bool holds, const std::string& message) {
  if (!holds) throw std::invalid_argument(message);
}

// Throws std::invalid_argument naming the cell and the value that cannot be.
void check(const SkinModel& model) {
  std::set<skin::CellKey> keys;
  for (std::size_t i = 0; i < model.size(); ++i) {
    const std::string cell = "cell " + std::to_string(i) + ": ";
    demand(keys.insert(model.key[i]).second, cell + "key " + std::to_string(model.key[i]) + " is given twice");
    demand(model.link[i] >= 0 && static_cast<std::size_t>(model.link[i]) < model.link_names.size(),
           cell + "link " + std::to_string(model.link[i]) + " is none of the " +
               std::to_string(model.link_names.size()) + " links");
    for (const double value : model.link_from_cell_rotation[i]) demand(std::isfinite(value), cell + "pose not finite");
    for (const double value : model.link_from_cell_translation[i]) {
      demand(std::isfinite(value), cell + "pose not finite");
    }
    for (const skin::Neighbour& neighbour : model.neighbours[i]) {
      demand(neighbour.cell >= -1 && neighbour.cell < static_cast<std::int64_t>(model.size()),
             cell + "neighbour " + std::to_string(neighbour.cell) + " is no cell; -1 means none");
      demand(neighbour.cell < 0 || (neighbour.port >= 1 && neighbour.port <= 4),
             cell + "its neighbour's port " + std::to_string(neighbour.port) + " is not between 1 and 4");
    }
  }
}

SkinModel make_model(std::vector<std::string> link_names, InputArray<std::uint32_t> key, InputArray<std::int32_t> link,
                     Input<double, nb::shape<-1, 4, 4>> link_from_cell,
                     Input<std::int32_t, nb::shape<-1, 4, 2>> neighbours, InputArray<std::int32_t> patch) {
  const std::size_t cells = key.shape(0);
  require_cells("link", link.shape(0), cells);
  require_cells("link_from_cell", link_from_cell.shape(0), cells);
  require_cells("neighbours", neighbours.shape(0), cells);
  require_cells("patch", patch.shape(0), cells);
  SkinModel model;
  model.link_names = std::move(link_names);
  model.key.assign(key.data(), key.data() + cells);
  model.link.assign(link.data(), link.data() + cells);
  model.patch.assign(patch.data(), patch.data() + cells);
  for (std::size_t cell = 0; cell < cells; ++cell) {
    const double* pose = link_from_cell.data() + 16 * cell;
    model.link_from_cell_rotation.push_back(
        {pose[0], pose[1], pose[2], pose[4], pose[5], pose[6], pose[8], pose[9], pose[10]});
    model.link_from_cell_translation.push_back({pose[3], pose[7], pose[11]});
    const std::int32_t* row = neighbours.data() + 8 * cell;
    auto& ports = model.neighbours.emplace_back();
    for (std::size_t port = 0; port < 4; ++port)
      ports[port] = {row[2 * port], static_cast<std::uint8_t>(row[2 * port + 1])};
  }
  check(model);
  return model;
}

// A vector of the state as a numpy array over its memory; `row` values a cell, 0: a flat array.
template <auto member, typename Value>
void bind_array(nb::class_<SkinState>& state, const char* name, std::size_t row, const char* doc) {
  const auto view = [row](nb::handle_t<SkinState> self) {
    auto& vector = nb::cast<SkinState&>(self).*member;
    const std::size_t shape[2] = {vector.size(), row};
    return nb::ndarray<nb::numpy, Value>(reinterpret_cast<Value*>(vector.data()), row == 0 ? 1 : 2, shape, self);
  };
  state.def_prop_ro(name, view, nb::rv_policy::automatic, doc);
}

void bind_skin_computed_torque(nb::module_& module) {
  using skin::SkinTorque;
  using skin::TorqueReader;
  nb::class_<SkinTorque>(module, "SkinTorque", "What the skin asks of n joints, as its own cells have computed it.")
      .def(nb::init<std::size_t>(), "joints"_a)
      .def_prop_ro(
          "joint", [](const SkinTorque& self) { return copy_of(std::span<const double>(self.joint)); },
          nb::rv_policy::move, "(n) Nm, N where a joint slides; zero unless fresh")
      .def_ro("stamp_ns", &SkinTorque::stamp_ns, "host clock when the oldest of the limbs' epochs began")
      .def_ro("cells", &SkinTorque::cells, "summed")
      .def_ro("active", &SkinTorque::active, "of them, in contact")
      .def_ro("fresh", &SkinTorque::fresh, "every limb has said something new")
      .def_ro("saturated", &SkinTorque::saturated, "a sum has left its range");
  nb::class_<TorqueReader>(module, "TorqueReader", "Fills a SkinTorque from the limbs' newest vectors of the driver.")
      .def(
          "__init__",
          [](TorqueReader* self, HostDriver& host,
             const std::vector<std::tuple<std::uint16_t, std::uint8_t, std::vector<std::size_t>>>& limbs,
             std::size_t joints, double step, double fresh_s) {
            std::vector<skin::LimbPlace> places;
            for (const auto& [group, limb, indices] : limbs) places.push_back({group, limb, indices});
            new (self) TorqueReader(host.driver.torques(), std::move(places), joints,
                                    {.step = step, .fresh_ns = static_cast<std::int64_t>(fresh_s * 1e9)});
          },
          "driver"_a, "limbs"_a, "joints"_a, nb::kw_only(), "step"_a,
          "fresh_s"_a = 1e-9 * static_cast<double>(skin::TorqueReaderOptions{}.fresh_ns), nb::keep_alive<1, 2>(),
          R"(`limbs`: (section unit group, limb, indices of the robot's joints in the order of its vector); `joints`: of the
robot; `step`: Nm of the vectors. A vector is stale when its epoch began more than `fresh_s` ago.
Raises ValueError for a joint that there is not.)")
      .def("read", &TorqueReader::read, "now_ns"_a, "torque"_a,
           "Fills `torque` as of host time `now_ns`; never waits.");
}

}  // namespace

void bind_skin(nb::module_ module) {
  bind_skin_computed_torque(module);
  bind_skin_input(module);
  module.attr("STANDARD_GRAVITY_MPS2") = skin::standard_gravity;
  module.attr("ACCELERATION_STEP_MPS2") = skin::acceleration_x_step * skin::standard_gravity;
  nb::enum_<Health>(module, "Health", nb::is_arithmetic(), "How far a cell's values can be believed.")
      .value("alive", Health::alive)
      .value("stale", Health::stale)
      .value("stuck", Health::stuck)
      .value("dead", Health::dead)
      .value("never_seen", Health::never_seen);
  nb::class_<SkinModel>(module, "SkinModel", "The constant part of a skin of N cells; lengths in m.")
      .def(
          "__init__",
          [](SkinModel* self, std::vector<std::string> link_names, InputArray<std::uint32_t> key,
             InputArray<std::int32_t> link, Input<double, nb::shape<-1, 4, 4>> link_from_cell,
             Input<std::int32_t, nb::shape<-1, 4, 2>> neighbours, InputArray<std::int32_t> patch) {
            new (self) SkinModel(make_model(std::move(link_names), key, link, link_from_cell, neighbours, patch));
          },
          "link_names"_a, "key"_a, "link"_a, "link_from_cell"_a, "neighbours"_a, "patch"_a,
          "key (N) uint32 = section unit << 16 | id; link (N) int32 indexes link_names; link_from_cell (N, 4, 4), z\n"
          "outward; neighbours (N, 4, 2) int32 = index or -1 and port 1 to 4; patch (N) int32, -1: none.")
      .def("__len__", &SkinModel::size)
      .def_prop_ro(
          "link_names", [](const SkinModel& self) { return self.link_names; }, "that `link` indexes")
      .def_prop_ro(
          "key", [](const SkinModel& self) { return copy_of(std::span<const std::uint32_t>(self.key)); },
          nb::rv_policy::move, "(N)")
      .def_prop_ro(
          "link", [](const SkinModel& self) { return copy_of(std::span<const std::int32_t>(self.link)); },
          nb::rv_policy::move, "(N) index into link_names")
      .def_prop_ro(
          "patch", [](const SkinModel& self) { return copy_of(std::span<const std::int32_t>(self.patch)); },
          nb::rv_policy::move, "(N) index of the patch, -1: none")
      .def_prop_ro(
          "link_from_cell",
          [](const SkinModel& self) {
            std::vector<double> poses;
            for (std::size_t cell = 0; cell < self.size(); ++cell) {
              const auto& turn = self.link_from_cell_rotation[cell];
              const auto& place = self.link_from_cell_translation[cell];
              for (std::size_t row = 0; row < 3; ++row)
                poses.insert(poses.end(), {turn[3 * row], turn[3 * row + 1], turn[3 * row + 2], place[row]});
              poses.insert(poses.end(), {0, 0, 0, 1});
            }
            return copy_of(std::span<const double>(poses), {self.size(), 4, 4});
          },
          nb::rv_policy::move, "(N, 4, 4) metres")
      .def(
          "set_force_calibration",
          [](SkinModel& self, Input<double, nb::shape<-1, 3>> offset, Input<double, nb::shape<-1, 3, 3>> matrix) {
            demand(offset.shape(0) == self.size() && matrix.shape(0) == self.size(),
                   "a calibration of " + std::to_string(offset.shape(0)) + " cells, the model has " +
                       std::to_string(self.size()));
            self.force_calibration.resize(self.size());
            for (std::size_t cell = 0; cell < self.size(); ++cell) {
              skin::ForceCalibration& one = self.force_calibration[cell];
              for (std::size_t i = 0; i < 3; ++i) one.offset[i] = static_cast<float>(offset.data()[3 * cell + i]);
              for (std::size_t i = 0; i < 9; ++i)
                one.force_from_reading[i] = static_cast<float>(matrix.data()[9 * cell + i]);
            }
          },
          "offset_n"_a, "force_from_reading"_a,
          "What the sensors of each cell felt, force_from_reading (reading - offset): offset (N, 3) newton, matrix\n"
          "(N, 3, 3). Readers made of this model use it from the start.")
      .def_prop_ro(
          "has_force_calibration", [](const SkinModel& self) { return !self.force_calibration.empty(); },
          "whether readers made of it calibrate forces");
  auto state = nb::class_<SkinState>(module, "SkinState",
                                     "What the skin feels in one cycle; the arrays share the state's memory.")
                   .def(
                       "__init__",
                       [](SkinState* self, std::size_t cells, const std::vector<std::string>& sensors) {
                         const skin::SensorSet present = sensors.empty() ? skin::all_sensors : sensor_set(sensors);
                         new (self) SkinState();
                         self->resize(cells, present);
                       },
                       "cells"_a, "sensors"_a = std::vector<std::string>{},
                       "sensors: names of those that the skin has (`firmware.SENSORS`); none named: all.")
                   .def_prop_ro(
                       "sensors", [](const SkinState& self) { return sensor_names(self.sensors); },
                       "names of those that the skin has; columns of the others are NaN")
                   .def("__len__", &SkinState::size)
                   .def("__repr__",
                        [](const SkinState& self) {
                          return "<SkinState of " + std::to_string(self.size()) + " cells, at " +
                                 std::to_string(self.time_ns) + " ns>";
                        })
                   .def_rw("time_ns", &SkinState::time_ns, "host clock of this snapshot");
#define ROBOTSKIN_BIND_COLUMN(name, is_signed, first, channels, column, blank, unit)      \
  bind_array<&SkinState::column, float>(state, #column, (channels) == 1 ? 0 : (channels), \
                                        (channels) == 1 ? "(N) " unit : "(N, " #channels ") " unit);
  RS_SENSORS(ROBOTSKIN_BIND_COLUMN)
#undef ROBOTSKIN_BIND_COLUMN
  bind_array<&SkinState::distance, float>(state, "distance", 0, "(N) metres, inf where nothing is near");
  bind_array<&SkinState::stamp_ns, std::int64_t>(state, "stamp_ns", 0, "(N) host clock at the sample");
  bind_array<&SkinState::health, std::uint8_t>(state, "health", 0, "(N) values of Health");
  bind_array<&SkinState::saturated, std::uint8_t>(state, "saturated", 0, "(N) 1 where a channel is at its end");
  nb::class_<SkinReader>(module, "SkinReader", "Fills a SkinState from the driver's newest samples.")
      .def(
          "__init__",
          [](SkinReader* self, HostDriver& host, const SkinModel& model, double clock_fresh_s, double event_fresh_s,
             double stuck_after_s, float tare_limit_n) {
            const std::vector<driver::CellKey>& keys = host.driver.keys();
            demand(keys.size() >= model.size(), "the model has " + std::to_string(model.size()) +
                                                    " cells, the driver only " + std::to_string(keys.size()));
            for (std::size_t i = 0; i < model.size(); ++i) {
              demand(keys[i] == model.key[i], "row " + std::to_string(i) + " of the driver is cell " +
                                                  std::to_string(keys[i]) + ", in the model it is " +
                                                  std::to_string(model.key[i]));
            }
            skin::ReaderOptions options;
            options.clock_fresh_ns = static_cast<std::int64_t>(clock_fresh_s * 1e9);
            options.event_fresh_ns = static_cast<std::int64_t>(event_fresh_s * 1e9);
            options.stuck_after_ns = static_cast<std::int64_t>(stuck_after_s * 1e9);
            options.tare_limit_n = tare_limit_n;
            new (self) SkinReader(host.driver.samples(), model, options);
          },
          "driver"_a, "model"_a, nb::kw_only(), "clock_fresh_s"_a = 0.02,
          "event_fresh_s"_a = 1e-9 * static_cast<double>(skin::ReaderOptions{}.event_fresh_ns), "stuck_after_s"_a = 5.0,
          "tare_limit_n"_a = 0.5, nb::keep_alive<1, 2>(),
          R"(`model` must list the driver's cells in its order (ValueError). A cell in event mode is stale when its sample
is older than `event_fresh_s`; one in clock mode when it is older than five of its periods, at least `clock_fresh_s` and
at most `event_fresh_s`; stuck when its acceleration has not changed for `stuck_after_s` while
that of others does.)")
      .def("read", &SkinReader::read, "now_ns"_a, "state"_a, nb::call_guard<nb::gil_scoped_release>(),
           "Fills `state` (a SkinState of the model's size) as of host time `now_ns`; allocates nothing, never waits.")
      .def(
          "tare", [](SkinReader& self, double seconds) { self.tare(static_cast<std::int64_t>(seconds * 1e9)); },
          "seconds"_a,
          "Averages the forces over the coming `seconds` and subtracts them from then on. Nothing may touch the skin.")
      .def_prop_ro("taring", &SkinReader::taring, "a tare is under way")
      .def_prop_ro("tare_refused", &SkinReader::tare_refused,
                   "Force sensors whose offset was too large to be one: left as it is.")
      .def_prop_ro(
          "force_offset",
          [](const SkinReader& self) {
            const std::span<const float> offsets(self.force_offset().data()->data(), 3 * self.force_offset().size());
            return copy_of(offsets, {self.force_offset().size(), 3});
          },
          nb::rv_policy::move, "(N, 3) newton, what the tare subtracts")
      .def_prop_ro(
          "measured_force",
          [](nb::handle_t<SkinReader> self) {
            auto& forces = nb::cast<SkinReader&>(self).measured_force();
            const std::size_t shape[2] = {forces.size(), 3};
            return nb::ndarray<nb::numpy, const float>(forces.data()->data(), 2, shape, self);
          },
          nb::rv_policy::automatic, nb::sig("def measured_force(self) -> NDArray[numpy.float32]"),
          "(N, 3) newton of each cell's last sample, before any zero is taken; it shares the reader's memory.");
}

}  // namespace robotskin::bindings
