// SPDX-License-Identifier: Apache-2.0
// The Python face of the core: one submodule a stage, each bound in its own file.
#include <nanobind/nanobind.h>

#include "bindings/bindings.hpp"

NB_MODULE(_core, module) {
  // A script's names, a task of its own among them, may tie objects together until the process ends, which frees them.
  nanobind::set_leak_warnings(false);
  module.doc() = "The compiled core of robotskin: one submodule for each stage of the flow.";
  robotskin::bindings::bind_all(module);
}
