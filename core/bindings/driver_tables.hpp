// SPDX-License-Identifier: Apache-2.0
// What the driver knows as tables for Python: dictionaries of numpy arrays, one row a cell, unit or limb.
#pragma once

#include <nanobind/nanobind.h>

#include "driver/driver.hpp"

namespace robotskin::bindings {

nanobind::dict statistics_dict(const driver::Statistics& statistics);
nanobind::dict samples_dict(driver::SnapshotTable<driver::Sample>& table);
nanobind::dict topology_dict(driver::SnapshotTable<driver::TopologyRow>& table,
                             driver::SnapshotTable<driver::Sample>& samples);
nanobind::list units_list(driver::SnapshotTable<driver::UnitRow>& table);
nanobind::dict torques_dict(driver::SnapshotTable<driver::LimbTorque>& table);
// Takes the replies that have come since the last call.
nanobind::list replies_list(driver::Driver& driver);

}  // namespace robotskin::bindings
