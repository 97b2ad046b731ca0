// SPDX-License-Identifier: Apache-2.0
// Binds the inputs of a loop: the driver's, and those written in Python.
#include "skin/skin_input.hpp"

#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <tuple>

#include "bindings/bindings.hpp"
#include "bindings/driver.hpp"
#include "bindings/python_input.hpp"
#include "skin/datagram_input.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::bindings {

using skin::DatagramInput;
using skin::InputStatus;
using skin::JointCode;
using skin::SkinInput;

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
      .def(nb::init<std::size_t, double>(), "cell_count"_a,
           "fresh_s"_a = 1e-9 * static_cast<double>(skin::sample_fresh_ns),
           "Raises ValueError unless fresh_s is greater than 0.")
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
}

}  // namespace robotskin::bindings
