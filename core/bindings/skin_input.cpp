// SPDX-License-Identifier: Apache-2.0
// Binds the inputs of a loop: the driver's, and those written in Python.
#include "skin/skin_input.hpp"

#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <cstring>
#include <tuple>

#include "bindings/bindings.hpp"
#include "bindings/driver.hpp"
#include "bindings/python_input.hpp"
#include "bindings/sensor_names.hpp"
#include "skin/datagram_input.hpp"
#include "skin/foreign_input.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::bindings {

using skin::DatagramInput;
using skin::InputStatus;
using skin::JointCode;
using skin::SkinInput;

using skin::ForeignInput;

// Takes the values of the sensors that there are, in the order of channels.h.
void put_sample(skin::ForeignSample& sample, skin::SensorSet sensors, const float* value) {
#define ROBOTSKIN_PUT(name, is_signed, first, channels, column, blank, unit) \
  if ((sensors & skin::only(skin::Sensor::name)) != 0) {                     \
    std::memcpy(&sample.column, value, sizeof sample.column);                \
    value += channels;                                                       \
  }
  RS_SENSORS(ROBOTSKIN_PUT)
#undef ROBOTSKIN_PUT
}

std::size_t values_of(skin::SensorSet sensors) {
  std::size_t count = 0;
#define ROBOTSKIN_COUNT(name, is_signed, first, channels, column, blank, unit) \
  if ((sensors & skin::only(skin::Sensor::name)) != 0) count += channels;
  RS_SENSORS(ROBOTSKIN_COUNT)
#undef ROBOTSKIN_COUNT
  return count;
}

void bind_foreign_input(nb::module_& module) {
  nb::class_<ForeignInput, SkinInput>(
      module, "ForeignInput",
      R"(The samples of another maker's skin, put in by one thread while the loop reads in another; neither waits.)")
      .def(
          "__init__",
          [](ForeignInput* self, std::size_t cells, const std::vector<std::string>& sensors, double fresh_s,
             double tare_limit_n) {
            new (self) ForeignInput(cells, {.sensors = sensor_set(sensors),
                                            .fresh_ns = static_cast<std::int64_t>(fresh_s * 1e9),
                                            .tare_limit_n = static_cast<float>(tare_limit_n)});
          },
          "cell_count"_a, "sensors"_a, "fresh_s"_a = 1e-9 * static_cast<double>(skin::sample_fresh_ns),
          "tare_limit_n"_a = skin::ForeignOptions{}.tare_limit_n,
          "sensors: names of those that the skin has (`firmware.SENSORS`). Raises ValueError for none, for no cell and "
          "for a bound of 0 or less.")
      .def_prop_ro(
          "values", [](const ForeignInput& self) { return values_of(self.sensors()); },
          "V of a sample: the channels of its sensors, in the order of `firmware.SENSORS`")
      .def(
          "put",
          [](ForeignInput& self, std::int64_t stamp_ns, std::int64_t now_ns, InputArray<std::int32_t> cells,
             nb::ndarray<const float, nb::ndim<2>, nb::c_contig, nb::device::cpu> values,
             nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu> saturated) {
            const std::size_t width = values_of(self.sensors());
            if (values.shape(0) != cells.shape(0) || saturated.shape(0) != cells.shape(0) || values.shape(1) != width)
              throw std::invalid_argument("samples of " + std::to_string(cells.shape(0)) + " cells: values must be (" +
                                          std::to_string(cells.shape(0)) + ", " + std::to_string(width) + ")");
            for (const std::int32_t cell : span_of(cells))
              if (cell < 0 || static_cast<std::size_t>(cell) >= self.cell_count())
                throw std::invalid_argument("cell " + std::to_string(cell) + ": there are cells 0 to " +
                                            std::to_string(self.cell_count() - 1));
            const nb::gil_scoped_release release;
            for (std::size_t i = 0; i < cells.shape(0); ++i) {
              skin::ForeignSample& sample = self.change(static_cast<std::size_t>(cells.data()[i]));
              sample.stamp_ns = stamp_ns;
              ++sample.samples;
              sample.saturated = saturated.data()[i];
              put_sample(sample, self.sensors(), values.data() + i * width);
            }
            self.publish(now_ns);
          },
          "stamp_ns"_a, "now_ns"_a, "cells"_a, "values"_a, "saturated"_a,
          R"(Samples of M cells that were taken at `stamp_ns` of the host's clock, handed over at `now_ns`. cells (M)
int32; values (M, V) float32, SI units; saturated (M) bool. Always the same thread. Raises ValueError for other shapes,
and for a cell that there is not.)")
      .def("end", &ForeignInput::end, "No more will come: the skin is disconnected. Any thread.")
      .def(
          "tare", [](ForeignInput& self, double seconds) { self.tare(static_cast<std::int64_t>(seconds * 1e9)); },
          "seconds"_a,
          "Averages the forces over the coming `seconds` and subtracts them from then on. Nothing may touch the skin.")
      .def_prop_ro("taring", &ForeignInput::taring, "a tare is under way")
      .def_prop_ro("tare_refused", &ForeignInput::tare_refused,
                   "Cells whose offset was too large to be one: left as it is.");
}

void bind_skin_input(nb::module_& module) {
  nb::enum_<InputStatus>(module, "InputStatus", "How a skin answered a read.")
      .value("ok", InputStatus::ok)
      .value("nothing_new", InputStatus::nothing_new)
      .value("disconnected", InputStatus::disconnected);
  nb::class_<SkinInput, PythonInput>(module, "SkinInput",
                                     R"(Where a skin's samples come from; derive from it for a skin of your own.

Override `read(now_ns, state) -> InputStatus`: fill what is new in the state (a SkinState, always the same one), in the
order of the skin model. Of each such cell set the values, `stamp_ns` and `health`; set `state.time_ns` to the host clock
of the newest of it. A cell older than `fresh_s` is stale whatever `health` says. `tell_joints(now_ns, position)` may be
overridden, too: position (n) rad or m of the robot's joints. An input that raises counts as disconnected.)")
      .def(nb::init<std::size_t, double, const std::vector<std::string>&>(), "cell_count"_a,
           "fresh_s"_a = 1e-9 * static_cast<double>(skin::sample_fresh_ns), "sensors"_a = std::vector<std::string>{},
           "sensors: names of those that the skin has (`firmware.SENSORS`); none named: all. Raises ValueError unless "
           "fresh_s is greater than 0.")
      .def_prop_ro(
          "sensors", [](const SkinInput& self) { return sensor_names(self.sensors()); },
          "names of those that the skin has")
      .def_prop_ro("cell_count", &SkinInput::cell_count, "N of the states that it fills")
      .def_prop_ro("fresh_ns", &SkinInput::fresh_ns, "how old a sample of a living cell may be")
      .def(
          "tell_joints",
          [](SkinInput& self, std::int64_t now_ns, InputArray<double> position) {
            self.tell_joints(now_ns, span_of(position));
          },
          "now_ns"_a, "position"_a, "Where the robot's joints are, (n) rad or m, for a skin that computes with it.")
      .def("read", &SkinInput::read, "now_ns"_a, "state"_a, "Fills what is new in the state.");
  nb::class_<DatagramInput, SkinInput>(module, "DatagramInput", "The samples of our own cells, as the driver has them.")
      .def(nb::init<skin::SkinReader&>(), "reader"_a, nb::keep_alive<1, 2>())
      .def(
          "take_skin_computed_torque",
          [](DatagramInput& self, HostDriver& host, skin::TorqueReader& torques,
             const std::vector<std::tuple<std::uint16_t, std::uint8_t, std::vector<std::tuple<std::size_t, char>>>>&
                 limbs,
             std::size_t joint_count) {
            std::vector<skin::LimbCodes> codes;
            for (const auto& [group, limb, joints] : limbs) {
              codes.push_back({group, limb, {}});
              for (const auto& [joint, kind] : joints)
                codes.back().joints.push_back({joint, kind == 't'   ? JointCode::Kind::turn
                                                      : kind == 's' ? JointCode::Kind::slide
                                                                    : JointCode::Kind::none});
            }
            self.take_skin_computed_torque(host.driver, torques, std::move(codes), joint_count);
          },
          "driver"_a, "torques"_a, "limbs"_a, "joint_count"_a, nb::keep_alive<1, 2>(), nb::keep_alive<1, 3>(),
          "From then on the cells hear where the joints are. limbs: [(section unit group, limb, [(joint, 't' turns, "
          "'s' "
          "slides or 'n' not needed)])].")
      .def("tell", &DatagramInput::tell, "on"_a, "False: the cells hear no more where the joints are.")
      .def_prop_ro("skin_computed_torque", &DatagramInput::skin_computed_torque, nb::rv_policy::reference_internal,
                   "What the skin has computed itself (SkinTorque); None where it computes nothing.");
  bind_foreign_input(module);
}

}  // namespace robotskin::bindings
