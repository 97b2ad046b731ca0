// The Python face of the core: one submodule a stage, each bound in its own file.
#include <nanobind/nanobind.h>

#include "bindings/bindings.hpp"

NB_MODULE(_core, module) {
  module.doc() = "The compiled core of robotskin: one submodule for each stage of the flow.";
  robotskin::bindings::bind_all(module);
}
