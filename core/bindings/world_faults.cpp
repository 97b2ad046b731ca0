// SPDX-License-Identifier: Apache-2.0
// Binds faults of the network: values, text, drawing.
#include <nanobind/nanobind.h>
#include <nanobind/operators.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include "bindings/bindings.hpp"
#include "bindings/world.hpp"
#include "world/network/fault.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::bindings {

using world::Fault;
using world::FaultError;
using world::Wiring;

void bind_world_faults(nb::module_& module) {
  error_class<FaultError>(module, "FaultError", "A fault that cannot be read, or whose target does not exist.");
  nb::class_<Fault>(module, "Fault", "Something that goes wrong in a network at a time; its text can be read again.")
      .def(
          "__init__", [](Fault* self, const std::string& text) { new (self) Fault(world::parse_fault(text)); },
          "text"_a, "For instance 'cut:cell=12,port=3@120ms'. Raises FaultError.")
      .def("__str__", [](const Fault& self) { return world::to_string(self); })
      .def("__repr__", [](const Fault& self) { return "Fault('" + world::to_string(self) + "')"; })
      .def(nb::self == nb::self, nb::sig("def __eq__(self, arg: object, /) -> bool"))
      .def_prop_ro(
          "kind", [](const Fault& self) { return std::string(world::name_of(self.kind)); }, "one of fault_kinds()")
      .def_ro("time_ns", &Fault::time_ns, "virtual time at which it strikes")
      .def_ro("cell", &Fault::cell, "-1: none")
      .def_ro("unit", &Fault::unit, "-1: none")
      .def_ro("port", &Fault::port, "0: all")
      .def_ro("lasts_ns", &Fault::lasts_ns, "0: for good");
  module.def(
      "fault_kinds",
      [] {
        std::vector<std::string> names;
        for (const std::string_view name : world::fault_names()) names.emplace_back(name);
        return names;
      },
      "Names of all kinds, as the text of a fault begins.");
  module.def("fault_help", &world::fault_help, "A line a kind: its keys, their values if left out, what happens.");
  module.def("parse_faults", &world::parse_faults, "text"_a, "wiring"_a, "seed"_a,
             "The faults of a specification in order of time; 'random:N@TIME' is drawn from the seed. Raises "
             "FaultError, also for targets that the wiring does not have.");
  module.def("draw_faults", &world::draw_faults, "wiring"_a, "count"_a, "from_ns"_a, "seed"_a,
             "Faults of any kind, half of them within 10 ms of the one before.");
  module.def(
      "faults_text", [](const std::vector<Fault>& faults) { return world::to_string(faults); }, "faults"_a,
      "One line that parse_faults reads as the same faults.");
}

}  // namespace robotskin::bindings
