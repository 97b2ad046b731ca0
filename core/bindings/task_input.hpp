// SPDX-License-Identifier: Apache-2.0
// What Python gives a task or a fusion to know of one tick.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <stdexcept>

#include "bindings/arrays.hpp"
#include "control/task.hpp"

namespace robotskin::bindings {

using Doubles = InputArray<double>;
using Shares = InputArray<float>;
using Rows = nanobind::ndarray<const double, nanobind::ndim<2>, nanobind::c_contig, nanobind::device::cpu>;

inline void require(bool accepted, const char* what) {
  if (!accepted) throw std::invalid_argument(what);
}

template <typename Call>
auto with_input(const RobotDynamics& dynamics, Doubles position, Doubles velocity, const skin::SkinState& skin,
                Shares share, double period_s, const Call& call) {
  require(position.shape(0) == dynamics.joint_count() && velocity.shape(0) == dynamics.joint_count(),
          "position and velocity must have one entry a joint");
  return call(control::TaskInput{dynamics, span_of(position), span_of(velocity), skin, span_of(share), period_s});
}

}  // namespace robotskin::bindings
