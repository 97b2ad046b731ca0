// The world stage is bound in three files: the body, the network with what steps both, and the network's survey.
#pragma once

#include <nanobind/nanobind.h>

#include "world/network/network.hpp"

namespace robotskin::bindings {

void bind_world_body(nanobind::module_& module);
void bind_world_network(nanobind::module_& module);
void bind_world_survey(nanobind::class_<world::Network>& network);

}  // namespace robotskin::bindings
