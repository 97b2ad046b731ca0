// The world stage is bound in two files: the body, and the network with what steps both.
#pragma once

#include <nanobind/nanobind.h>

namespace robotskin::bindings {

void bind_world_body(nanobind::module_& module);
void bind_world_network(nanobind::module_& module);

}  // namespace robotskin::bindings
