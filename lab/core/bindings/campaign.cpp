// SPDX-License-Identifier: Apache-2.0
// Binds the fault campaign and the model check.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bindings/lab.hpp"
#include "campaign/case_text.hpp"
#include "campaign/model_check.hpp"
#include "campaign/run_case.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::bindings {
namespace {

using campaign::Break;
using campaign::CaseReport;
using campaign::FaultCase;
using campaign::Invariant;
using campaign::ModelOptions;
using campaign::ModelReport;

void bind_cases(nb::module_& module) {
  nb::class_<Break>(module, "Break", "One invariant broken at one time.")
      .def_prop_ro("invariant", [](const Break& self) { return std::string(name_of(self.invariant)); })
      .def_prop_ro(
          "number", [](const Break& self) { return number_of(self.invariant); }, "as in I1 to I19")
      .def_ro("time_ns", &Break::time_ns, "virtual")
      .def_ro("cells", &Break::cells, "concerned")
      .def_prop_ro("values",
                   [](const Break& self) {
                     std::vector<std::tuple<std::string, std::int64_t>> values;
                     for (const campaign::Value& value : self.values) values.emplace_back(value.name, value.value);
                     return values;
                   })
      .def("__str__", &Break::text);

  nb::class_<FaultCase>(module, "FaultCase", "A skin, its section units, lines and clocks, and what strikes it when.")
      .def_ro("seed", &FaultCase::seed)
      .def_prop_ro("shape", [](const FaultCase& self) { return std::string(campaign::name_of(self.shape)); })
      .def_prop_ro("cells", [](const FaultCase& self) { return self.wiring.cell_count(); })
      .def_prop_ro("section_units", [](const FaultCase& self) { return self.wiring.units.size(); })
      .def_prop_ro("ports", &FaultCase::ports, "cables plugged in")
      .def_ro("keyed", &FaultCase::keyed, "ticks and commands are authenticated")
      .def_ro("whole_lines", &FaultCase::whole_lines, "no frame is lost or damaged by chance")
      .def_ro("while_forming", &FaultCase::while_forming, "faults begin before the network has formed")
      .def_prop_ro(
          "events", [](const FaultCase& self) { return self.workload.events; },
          "cells send what changes, not every sample")
      .def_prop_ro(
          "touched_percent", [](const FaultCase& self) { return self.workload.touched_percent; },
          "of the cells at a time, where they send what changes")
      .def_prop_ro(
          "events_hz", [](const FaultCase& self) { return self.workload.events_hz; }, "so often they look for a change")
      .def_prop_ro(
          "limbs", [](const FaultCase& self) { return self.workload.limbs; }, "whose torques are summed; 0: none")
      .def_prop_ro(
          "orders", [](const FaultCase& self) { return self.workload.orders; }, "the host sends commands and joints")
      .def_prop_ro(
          "touch", [](const FaultCase& self) { return self.workload.touch; }, "cells compute their own torques")
      .def_ro("duration_ns", &FaultCase::duration_ns)
      .def_prop_ro(
          "text", [](const FaultCase& self) { return campaign::text_of(self); },
          "All of it, many lines; `parse_case` reads it.")
      .def_prop_ro(
          "after_ns", [](const FaultCase& self) { return self.duration_ns - campaign::end_of(self.faults); },
          "from the last effect of the last fault to the end")
      .def_prop_ro("faults",
                   [](const FaultCase& self) {
                     std::vector<std::string> faults;
                     for (const world::Fault& fault : self.faults) faults.push_back(world::to_string(fault));
                     return faults;
                   })
      .def("__str__", &FaultCase::text);

  nb::class_<CaseReport>(module, "CaseReport", "What the checkers found in one case.")
      .def_ro("seed", &CaseReport::seed)
      .def_ro("breaks", &CaseReport::breaks, "of each invariant the first few")
      .def_ro("break_count", &CaseReport::break_count, "all")
      .def_ro("log_hash", &CaseReport::log_hash, "of every frame and datagram: equal for equal runs")
      .def_ro("events", &CaseReport::events)
      .def_ro("samples_taken", &CaseReport::samples_taken)
      .def_ro("samples_delivered", &CaseReport::samples_delivered)
      .def_ro("events_repeated", &CaseReport::events_repeated, "sent again, and marked so")
      .def_ro("crowded_out_most", &CaseReport::crowded_out_most,
              "samples that found no room after one fault, in trees within load")
      .def_ro("lost_overloaded", &CaseReport::lost_overloaded,
              "samples that were lost in trees that had more than their cables carry")
      .def_ro("excused", &CaseReport::excused, "samples that were false after memory was damaged")
      .def_ro("torque_sums", &CaseReport::torque_sums, "at the host")
      .def_ro("torque_epochs", &CaseReport::torque_epochs, "that had to be complete")
      .def_ro("frames_planted", &CaseReport::frames_planted, "forged, or played again")
      .def_ro("simulated_s", &CaseReport::simulated_s)
      .def_ro("longest_repair_ms", &CaseReport::longest_repair_ms, "flapping and hold-down included")
      .def_ro("longest_wait_ms", &CaseReport::longest_wait_ms, "of a sample in a cell, in whole networks")
      .def_ro("largest_control_share", &CaseReport::largest_control_share, "of a wire");

  module.def(
      "draw_case", &campaign::draw_case, "seed"_a, "ideal_processors"_a = false,
      "The case of a seed. Processors have 48 MHz and one flash wait state; ideal_processors: they take no time.");
  module.def("parse_case", &campaign::case_of, "text"_a,
             "The case that `FaultCase.text` tells. Raises ValueError, which names what cannot be read.");
  module.def("run_case", &campaign::run_case, nb::call_guard<nb::gil_scoped_release>(), "case"_a,
             "Run it under all checkers.");
  module.def(
      "shrink",
      [](const FaultCase& original, const std::string& invariant, int runs_max) {
        for (std::size_t i = 0; i < campaign::invariant_count; ++i)
          if (campaign::name_of(static_cast<Invariant>(i)) == invariant)
            return campaign::shrink(original, static_cast<Invariant>(i), runs_max);
        throw std::invalid_argument("no invariant '" + invariant + "': see invariants()");
      },
      nb::call_guard<nb::gil_scoped_release>(), "case"_a, "invariant"_a, "runs_max"_a = 200,
      "A smaller case that breaks the same invariant: without faults, then without cells. Raises ValueError for an "
      "unknown name.");
  module.def(
      "invariants",
      [] {
        std::vector<std::tuple<std::string, int, std::string>> all;
        for (std::size_t i = 0; i < campaign::invariant_count; ++i) {
          const auto invariant = static_cast<Invariant>(i);
          all.emplace_back(campaign::name_of(invariant), campaign::number_of(invariant), campaign::text_of(invariant));
        }
        return all;
      },
      "(name, number, what must be true) of each.");
}

void bind_model_check(nb::module_& module) {
  nb::class_<ModelOptions>(module, "ModelOptions", "A small network, and how far its states are explored.")
      .def(nb::init<>())
      .def_rw("cells", &ModelOptions::cells, "1 to 5")
      .def_rw("linked", &ModelOptions::linked, "bit j of linked[i]: a wire joins cells i and j")
      .def_rw("roots", &ModelOptions::roots, "bit i: cell i has a section unit's port")
      .def_rw("sequences", &ModelOptions::sequences, "ticks, 1 to 3")
      .def_rw("boots", &ModelOptions::boots, "reboots in a run, at most")
      .def_rw("quarantine", &ModelOptions::quarantine)
      .def_rw("states_max", &ModelOptions::states_max);
  nb::class_<ModelReport>(module, "ModelReport", "What the exploration found.")
      .def_ro("states", &ModelReport::states, "explored, up to the symmetries of the graph")
      .def_ro("transitions", &ModelReport::transitions)
      .def_ro("exhausted", &ModelReport::exhausted, "nothing is left to explore")
      .def_ro("loop", &ModelReport::loop)
      .def_ro("trace", &ModelReport::trace, "the shortest way to the loop, a step a line");
  module.def("check_model", &campaign::check_model, nb::call_guard<nb::gil_scoped_release>(), "options"_a,
             "Explore every state under the firmware's parent rule. Raises ValueError for options out of range.");
  module.def("largest_graphs", &campaign::largest_graphs, "cells"_a,
             "The graphs on so many cells to which no wire can be added; all others are parts of them.");
}

}  // namespace

void bind_campaign(nb::module_ module) {
  bind_cases(module);
  bind_model_check(module);
}

}  // namespace robotskin::bindings
