// SPDX-License-Identifier: Apache-2.0
// The world stage is bound in seven files: the body, its sensors, faults, the network with what steps both, its survey,
// its trials, a cell that runs elsewhere.
#pragma once

#include <nanobind/nanobind.h>

#include "world/body.hpp"
#include "world/network/network.hpp"

namespace robotskin::bindings {

void bind_world_body(nanobind::module_& module);
void bind_world_sensors(nanobind::module_& module, nanobind::class_<world::Body>& body);
void bind_world_faults(nanobind::module_& module);
void bind_world_network(nanobind::module_& module);
void bind_world_survey(nanobind::class_<world::Network>& network);
void bind_world_trial(nanobind::module_& module);
void bind_world_external_cell(nanobind::module_& module);

}  // namespace robotskin::bindings
