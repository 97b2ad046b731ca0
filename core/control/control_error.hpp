// SPDX-License-Identifier: Apache-2.0
// What a controller refuses before it ever moves a robot.
#pragma once

#include <stdexcept>

namespace robotskin::control {

// Gains, a skin or a model that do not fit together; the message names the thing, its value and what would fit.
class ControlError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace robotskin::control
