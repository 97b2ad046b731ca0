// SPDX-License-Identifier: Apache-2.0
// What the laboratory offers to Python; module.cpp calls these.
#pragma once

#include <nanobind/nanobind.h>

namespace robotskin::bindings {

void bind_baselines(nanobind::module_ module);
void bind_campaign(nanobind::module_ module);
void bind_firmware_parts(nanobind::module_ module);
void bind_firmware_cell(nanobind::module_& module);
void bind_firmware_section_unit(nanobind::module_& module);
void bind_traffic(nanobind::module_ module);

}  // namespace robotskin::bindings
