// SPDX-License-Identifier: Apache-2.0
// The Python face of the laboratory's compiled part. Wirings, faults, skins and robots are those of robotskin._core.
#include <nanobind/nanobind.h>

#include "bindings/lab.hpp"

NB_MODULE(_lab, module) {
  nanobind::set_leak_warnings(false);
  nanobind::module_::import_("robotskin._core");
  module.doc() =
      "The compiled part of the laboratory: baselines, the fault campaign, single cells and units, traffic without "
      "cells.";
  robotskin::bindings::bind_baselines(
      module.def_submodule("baselines", "What the product is measured against, and how long it takes."));
  robotskin::bindings::bind_campaign(
      module.def_submodule("campaign", "Random skins and faults under checkers of the network's laws."));
  robotskin::bindings::bind_firmware_parts(
      module.def_submodule("firmware", "Frames, and single cells and section units, driven input by input."));
  robotskin::bindings::bind_traffic(
      module.def_submodule("traffic", "The datagrams of section units, without simulating cells."));
}
