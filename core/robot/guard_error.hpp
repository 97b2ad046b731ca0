// SPDX-License-Identifier: Apache-2.0
// What the guard refuses to be built with.
#pragma once

#include <stdexcept>

namespace robotskin::robot {

// Limits that do not fit the robot; the message names the limit, its value and what would fit.
class GuardError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace robotskin::robot
